#pragma once
/// @file
/// Pattern points laid out for the inner loops, and where they fall in a picture.

#include <vector>

#include "calibration/mapping.h"
#include "finder/pattern.h"
#include "finder/pyramid.h"

namespace vsfind {

/// A PointSet as arrays: one entry per point, pattern pixels of full resolution from the origin.
struct PointArrays {
  std::vector<double> x;
  std::vector<double> y;
  std::vector<double> value;
  std::vector<double> gradient_x;
  std::vector<double> gradient_y;
  std::vector<double> laplacian;

  PointArrays() = default;
  explicit PointArrays(const std::vector<PatternPoint>& points);
  [[nodiscard]] int size() const { return static_cast<int>(x.size()); }
};

/// From pattern pixels to the pixels of one level of a picture, through pose and mapping.
struct Projection {
  const Mapping* mapping = nullptr;  ///< of the picture
  const Level* level = nullptr;
  double pitch = 1.0;  ///< plane units per pattern pixel

  /// Level coordinates of `count` pattern points.
  void level_from_pattern(const Pose& pose, const double* x, const double* y, int count, double* u, double* v) const;
  /// Derivative of level coordinates by plane coordinates at a plane point.
  [[nodiscard]] Eigen::Matrix2d level_from_plane_jacobian(const Eigen::Vector2d& plane) const;
};

}  // namespace vsfind
