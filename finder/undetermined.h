#pragma once
/// @file
/// What of a pose a pattern cannot tell: the direction along which it slides along itself, the angle of a disc.

#include <string>
#include <vector>

#include "finder/fit.h"
#include "finder/pattern.h"

namespace vsfind {

/// What the pattern does not determine of the pose's free values.
struct Undetermined {
  int directions = 0;          ///< of position: 0, 1 or 2 (2: the pattern is flat)
  double direction_deg = 0.0;  ///< where one: of the direction that cannot be told, 0 … 180 from +x toward +y
  bool angle = false;
  bool scale_x = false;  ///< with a common scale: that one
  bool scale_y = false;

  [[nodiscard]] bool anything() const { return directions > 0 || angle || scale_x || scale_y; }
};

/// Judged by the information of all the pattern's points (read through the Gaussian, with rough gradients), less what
/// noise of `noise_sigma` grey levels (of 255) in the picture puts into their gradients.
[[nodiscard]] Undetermined undetermined_by(const std::vector<PatternPoint>& all, const Freedom& freedom,
                                           double noise_sigma);

/// A sentence for each.
[[nodiscard]] std::vector<std::string> warnings_of(const Undetermined& what, const Freedom& freedom);

/// A direction in words: "x", "y", or "30 degrees (from +x toward +y)".
[[nodiscard]] std::string direction_text(double degrees);

}  // namespace vsfind
