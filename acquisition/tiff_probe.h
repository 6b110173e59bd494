#pragma once
/// @file
/// The part of probe_image() (image_probe.h) that knows TIFF.

#include <cstddef>
#include <span>

#include "acquisition/image_probe.h"

namespace vsfind {

/// Classic TIFF and BigTIFF, whose signature was seen: the first page's size, 0 where it is not told. Every strip or
/// tile of it must be there. Throws IoError as probe_image().
[[nodiscard]] ImageProbe probe_tiff(std::span<const std::byte> bytes);

}  // namespace vsfind
