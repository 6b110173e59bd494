#pragma once
/// @file
/// The centre of a circle's picture. For the boards of this folder, not a public door.

#include <Eigen/Core>
#include <optional>

#include "acquisition/image_view.h"

namespace vsfind {

struct Disc {
  Eigen::Vector2d centre;  ///< of area, frame pixels
  double area = 0.0;       ///< square frame pixels
};

/// The centre of area and the area of the spot at `guess` (frame pixels), each pixel counting as far as its grey value
/// goes from the surrounding to the spot's own; nothing beyond `reach` frame pixels from the guess belongs to it. Empty
/// where the reach leaves the image or there is no spot.
[[nodiscard]] std::optional<Disc> measure_disc(const ImageView& image, Field field, const Eigen::Vector2d& guess,
                                               double reach);

}  // namespace vsfind
