#pragma once
/// @file
/// The noise of a picture, measured in it.

#include "acquisition/image_view.h"

namespace vsfind {

/// Standard deviation of a pixel, in grey levels of 255 whatever the bits, rounding included: from the picture's
/// differences in both directions at once, which plain areas, ramps and straight edges along the grid do not excite
/// (Immerkaer 1996), what lies beyond three standard deviations left out. Saturated pixels are not looked at. 0 where
/// there is nothing to measure.
[[nodiscard]] double image_noise(const ImageView& image);

}  // namespace vsfind
