#pragma once
/// @file
/// Squares in a picture, roughly: candidates for fiducials.

#include <Eigen/Core>
#include <array>
#include <vector>

#include "acquisition/image_view.h"
#include "calibration/mapping.h"
#include "finder/pose.h"

namespace vsfind {

/// Right to a pixel or two.
struct RoughSquare {
  std::array<Eigen::Vector2d, 4> corners;  ///< pixels of the image, one after the other round the square
  Eigen::Vector2d centre{0.0, 0.0};        ///< pixels
  double side = 0.0;                       ///< plane units, the mean of the four
};

/// Filled squares or square outlines, dark or light, whole inside `where` (clipped to the image), whose sides on the
/// plane are alike within 20% and at least 10 pixels long; each once, the largest first, 64 at most. The threshold
/// between dark and light is found over `where`.
[[nodiscard]] std::vector<RoughSquare> find_squares(const ImageView& image, const Mapping& mapping, const Roi& where);

/// The four that serve as fiducials around a place: alike in size, the place between them, as far apart as can be.
/// Squares whose centre lies nearer to the place than `clear` (pixels) are the pattern's own. Empty where there are no
/// such four; ordered top left, top right, bottom right, bottom left (as seen).
[[nodiscard]] std::vector<RoughSquare> four_around(const std::vector<RoughSquare>& squares,
                                                   const Eigen::Vector2d& place, double clear);

}  // namespace vsfind
