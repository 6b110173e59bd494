#pragma once
/// @file
/// The text lines of a YUV4MPEG2 recording, as pure functions over bytes: the line that opens the stream and the line
/// that opens every frame. They take any bytes, allocate nothing that the input sizes, and throw IoError with the
/// complaint alone; who knows the file puts its name before it.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "acquisition/frame.h"
#include "acquisition/source.h"

namespace vsfind {

inline constexpr int y4m_max_side = 65536;                             ///< pixels, either way
inline constexpr std::int64_t y4m_max_pixels = std::int64_t{1} << 30;  ///< of a frame
inline constexpr std::size_t y4m_max_line = 1024;                      ///< bytes of either line, its newline included

/// `YUV4MPEG2 W640 H480 F25:1 It A59:54 Cmono …`
struct Y4mHeader {
  int width = 0;   ///< 1 … 65536
  int height = 0;  ///< 1 … 65536, rows of a whole frame
  int bits = 8;    ///< of a sample, 8 to 16; from 9 on two bytes, little-endian, the value in the low bits
  FieldOrder order = FieldOrder::unknown;
  bool mixed = false;  ///< Im: every frame's line tells its own order
  Ratio pixel_aspect;
  Ratio frame_rate;
  std::size_t luma_bytes = 0;    ///< of a frame
  std::size_t chroma_bytes = 0;  ///< of a frame, after its luma
};

/// What vsfind adds to a frame's line so that the frame comes back as it was; other programs ignore it:
/// `XVSFIND=` sequence `,` timestamp_ns `,` one letter each for clock (n m r d f), status (g i c), field (f t b),
/// order (p t b u), picture (i an image, e empty) and the moment that the timestamp tells (u s e: unknown, start, end;
/// unknown where recordings of earlier versions lack it). The numbers have 20 characters each, so that all lines are
/// alike in length; the line is far below the 80 characters that other readers allow.
struct Y4mTag {
  std::uint64_t sequence = 0;
  std::int64_t timestamp_ns = 0;
  Clock clock = Clock::none;
  FrameStatus status = FrameStatus::good;
  Field field = Field::frame;
  FieldOrder order = FieldOrder::unknown;
  bool empty = false;
  StampedAt stamped_at = StampedAt::unknown;
};

/// `FRAME Ittp XVSFIND=…`
struct Y4mFrameLine {
  std::optional<FieldOrder> order;  ///< the I parameter
  std::optional<Y4mTag> tag;
};

/// The stream's line, without its newline.
[[nodiscard]] Y4mHeader parse_y4m_header(std::string_view line);
/// A frame's line, without its newline.
[[nodiscard]] Y4mFrameLine parse_y4m_frame_line(std::string_view line);

/// The line, with its newline, for mono frames of that width, height, bits, order, aspect and rate.
[[nodiscard]] std::string format_y4m_header(const Y4mHeader& header);
/// The line, with its newline.
[[nodiscard]] std::string format_y4m_frame_line(const Y4mTag& tag);

/// The first bytes of `bytes` in quotes, unprintable ones as \xNN: for complaints.
[[nodiscard]] std::string quoted(std::string_view bytes);

}  // namespace vsfind
