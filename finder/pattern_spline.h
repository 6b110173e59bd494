#pragma once
/// @file
/// The pattern's picture between its pixels.

#include <vector>

#include "finder/pattern.h"

namespace vsfind {

/// Interpolates a pattern's picture by a cubic B-spline (Unser 1999), which passes through its pixels.
class PatternSpline {
 public:
  PatternSpline() = default;
  explicit PatternSpline(const PatternImage& image);

  /// Value (0 … 255), gradient and Laplacian at pattern pixels (x, y) from the origin; false where the picture or the
  /// pattern does not reach.
  bool read(double x, double y, PatternPoint& point) const;

 private:
  int width_ = 0;
  int height_ = 0;
  double origin_x_ = 0.0;
  double origin_y_ = 0.0;
  std::vector<float> coefficients_;
  std::vector<std::uint8_t> mask_;
};

}  // namespace vsfind
