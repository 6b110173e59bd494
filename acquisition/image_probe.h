#pragma once
/// @file
/// What kind of image some bytes are, how large, and whether they are all there: looked at before a decoder gets them,
/// so that a small file cannot ask for much memory and a damaged one is told in our words. Not a decoder.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace vsfind {

enum class ImageFormat : std::uint8_t { png, jpeg, bmp, tiff, pnm };

struct ImageProbe {
  ImageFormat format = ImageFormat::png;
  std::int64_t width = 0;   ///< as the file says; at least 1
  std::int64_t height = 0;  ///< likewise
  int maximum = 0;          ///< PNM: the value of white; else 0
};

/// Pure function over hostile bytes. Throws IoError with the complaint alone (no file name) where they are none of
/// these formats, are cut off, or fail the format's own check sums.
[[nodiscard]] ImageProbe probe_image(std::span<const std::byte> bytes);

/// A PNG that probe_image() took, without the chunks that do not change its pixels: colour profiles and the like, about
/// which the decoder would print warnings.
[[nodiscard]] std::vector<std::byte> png_pixels_only(std::span<const std::byte> png);

}  // namespace vsfind
