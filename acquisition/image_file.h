#pragma once
/// @file
/// A single picture from a file.

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "acquisition/image_view.h"

namespace vsfind {

inline constexpr int image_max_side = 65536;                             ///< pixels, either way
inline constexpr std::int64_t image_max_pixels = std::int64_t{1} << 28;  ///< of one picture

/// A mono picture in memory of its own. Copies share the memory, which nobody changes.
class Image {
 public:
  Image() = default;
  Image(std::shared_ptr<const std::byte> data, const ImageView& view) : data_(std::move(data)), view_(view) {}
  [[nodiscard]] const ImageView& view() const { return view_; }

 private:
  std::shared_ptr<const std::byte> data_;
  ImageView view_{};
};

/// Reads a PNG, JPEG, TIFF, BMP or PNM (PGM, PPM, PBM) file, told apart by content, of 8 or 16 bits; a PGM with a
/// maximum of 511, 1023, … 32767 has 9 to 15 bits. Colour becomes luma (ITU-R BT.601), alpha is ignored, an orientation
/// noted in the file is not applied; of several pages the first is read. Throws IoError in one line that names the
/// file where it cannot be read, is no such image, is damaged or cut off, or is larger than the bounds above.
[[nodiscard]] Image load_image(const std::string& path);

/// Whether a file of this name is taken for an image in a folder: .png .pgm .tif .tiff .bmp .jpg .jpeg .pnm .ppm, in
/// upper or lower case.
[[nodiscard]] bool has_image_ending(std::string_view name);
/// The endings, for complaints.
inline constexpr std::string_view image_endings = ".png .pgm .tif .tiff .bmp .jpg .jpeg .pnm .ppm";

}  // namespace vsfind
