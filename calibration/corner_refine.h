#pragma once
/// @file
/// The place of a chessboard corner to a few thousandths of a pixel. For the boards of this folder, not a public door.

#include <Eigen/Core>

#include "acquisition/image_view.h"

namespace vsfind {

/// Where a corner is looked for. All in frame pixels.
struct CornerGuess {
  Eigen::Vector2d position;
  Eigen::Vector2d along_row;     ///< the direction of one edge through the corner, any length
  Eigen::Vector2d along_column;  ///< of the other
  double radius = 5.0;           ///< of the window; half the distance to the next corner is too much
};

/// Fits a blurred corner, A + slope + B·erf(u/√2σ)·erf(v/√2σ) with u, v the distances from the two edges, to the grey
/// values around the guess. `image` holds the lines of `field`; positions are the frame's. Being symmetric about the
/// corner the model is not biased by blur. Moves the guess and returns true; false, the guess left alone, where the
/// window leaves the image, the contrast is missing, or the fit runs off by more than half the radius.
[[nodiscard]] bool refine_corner(const ImageView& image, Field field, CornerGuess& guess);

}  // namespace vsfind
