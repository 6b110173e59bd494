#pragma once
/// @file
/// A picture as a continuous function: the cubic B-spline through its pixels (Unser, Aldroubi & Eden 1993).

#include <vector>

namespace vsfind {

class SplineImage {
 public:
  SplineImage() = default;
  /// `values`: row by row, width · height.
  SplineImage(std::vector<float> values, int width, int height);

  struct Sample {
    double value = 0.0;
    double gradient_x = 0.0;
    double gradient_y = 0.0;
    double laplacian = 0.0;
  };
  /// At pixel coordinates; false where fewer than two pixels lie between the point and the border, or for NaN.
  bool sample(double x, double y, Sample& out) const;
  [[nodiscard]] bool empty() const { return coefficients_.empty(); }

 private:
  std::vector<float> coefficients_;
  int width_ = 0;
  int height_ = 0;
};

}  // namespace vsfind
