#pragma once
/// @file
/// Luma from the pixel formats of GigE Vision, by their numbers in the Pixel Format Naming Convention (PFNC).

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "acquisition/image_view.h"

namespace vsfind {

/// How pixels lie in memory, and what they are.
struct GigePixels {
  enum class Packing : std::uint8_t {
    plain,   ///< 8 bits in a byte, more in two, little-endian
    packed,  ///< GigE Vision's own: two pixels of 10 or 12 bits in three bytes, the low bits in the middle one
    dense,   ///< PFNC's p: bit after bit, the lowest first
  };
  enum class Colour : std::uint8_t {
    mono,
    bayer_rg,  ///< named after the first two pixels of the first row
    bayer_gr,
    bayer_gb,
    bayer_bg,
    rgb,
    bgr,
    rgba,
    bgra,
    luma_first,   ///< YUYV: luma and chroma take turns
    luma_second,  ///< UYVY
    uyyvyy,       ///< 4:1:1
  };
  int bits = 8;  ///< of a sample
  Packing packing = Packing::plain;
  Colour colour = Colour::mono;

  /// Bytes of a picture without padding between the rows.
  [[nodiscard]] std::size_t bytes(int width, int height) const;
  /// Whether the picture is luma as it lies in memory.
  [[nodiscard]] bool direct() const { return colour == Colour::mono && packing == Packing::plain; }
};

/// Nothing for a format that luma cannot be had from.
[[nodiscard]] std::optional<GigePixels> gige_pixels(std::uint32_t format);

/// The format's name of those that gige_pixels() takes, "" for others.
[[nodiscard]] std::string gige_pixel_format_name(std::uint32_t format);

/// Writes luma of the same bits into `to` (rows without padding; two bytes a pixel from 9 bits on) and returns its
/// view. `from` holds at least bytes(width, height), rows `stride` bytes apart where that is not 0 (plain packing
/// only).
ImageView luma_from_gige(const GigePixels& pixels, const std::byte* from, int width, int height, std::ptrdiff_t stride,
                         std::byte* to);

}  // namespace vsfind
