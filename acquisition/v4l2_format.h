#pragma once
/// @file
/// V4L2 pixel formats as pure functions: their names, and how luma lies in a buffer of them. No device is needed.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace vsfind {

/// Luma samples of one row of a buffer: the first one `offset` bytes after the row's begin, `step` bytes apart.
struct LumaLayout {
  int bits = 8;  ///< significant, in the low bits of one byte, or of two for more than 8
  int offset = 0;
  int step = 1;
  bool big_endian = false;
  int rows_numerator = 1;  ///< bytes of a buffer, all planes in it: stride · rows · this / rows_denominator
  int rows_denominator = 1;
};

/// The four characters of a format's code as a name: "GREY", "YUYV", "Y10", and "Y16-BE" for a big-endian one.
[[nodiscard]] std::string fourcc_name(std::uint32_t fourcc);
/// The code of such a name (upper and lower case are different); nothing where it is none.
[[nodiscard]] std::optional<std::uint32_t> fourcc_from_name(const std::string& name);

/// Where luma can be read as it stands: mono, and YUV with a luma sample of its own for every pixel. Nothing for all
/// other formats, which are converted (v4l2_convert.h).
[[nodiscard]] std::optional<LumaLayout> luma_layout(std::uint32_t fourcc);

/// Bytes of a buffer whose rows are `stride` apart.
[[nodiscard]] std::size_t picture_bytes(const LumaLayout& layout, std::size_t stride, std::size_t rows);

/// Copies luma to rows of `target`, in native byte order; bits above the significant ones are cut off. Rows of the
/// source may be misaligned, those of the target are 2-byte aligned where there are more than 8 bits.
void copy_luma(const LumaLayout& layout, const std::byte* source, std::ptrdiff_t source_stride, int width, int rows,
               std::byte* target, std::ptrdiff_t target_stride);

/// Motion JPEG and JPEG.
[[nodiscard]] bool is_jpeg(std::uint32_t fourcc);
/// Whether a JPEG picture is there to its end: its scan is followed by an EOI marker, whatever comes behind it. A
/// decoder is content with less, and leaves what is missing grey.
[[nodiscard]] bool jpeg_is_whole(std::span<const std::byte> picture);

}  // namespace vsfind
