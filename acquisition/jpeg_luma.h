#pragma once
/// @file
/// The luma of a JPEG file, by libjpeg directly: a damaged file is told from a whole one, and nothing is printed.

#include <cstddef>
#include <cstdint>
#include <span>

namespace vsfind {

/// Decodes into `luma`, width·height bytes without gaps. Throws IoError with the complaint alone (no file name) where
/// the file is of another size, is damaged, even if only a warning of libjpeg tells so, or has no luma (CMYK).
void decode_jpeg_luma(std::span<const std::byte> jpeg, std::uint8_t* luma, int width, int height);

}  // namespace vsfind
