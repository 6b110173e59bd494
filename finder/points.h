#pragma once
/// @file
/// Pattern points laid out for the inner loops, and where they fall in a picture.

#include <Eigen/Core>
#include <vector>

#include "calibration/mapping.h"
#include "finder/pattern.h"
#include "finder/pyramid.h"

namespace vsfind {

/// A PointSet as arrays, one entry per point, lengths rounded up as the kernels want it: pattern pixels of full
/// resolution from the origin, values less their mean, and the products that the fit's columns are made of.
struct PointArrays {
  int count = 0;
  std::vector<double> x;
  std::vector<double> y;
  Eigen::Vector2d middle{0.0, 0.0};
  std::vector<float> near_x;  ///< from the middle, in single precision
  std::vector<float> near_y;
  std::vector<float> value;
  std::vector<float> one;
  std::vector<float> gradient_x;
  std::vector<float> gradient_y;
  std::vector<float> laplacian;
  std::vector<float> stretch;  ///< ∂²/∂x² − ∂²/∂y² of the value
  std::vector<float> shear;    ///< 2·∂²/∂x∂y
  std::vector<float> gx_x;     ///< gradient_x · x / radius, and so on
  std::vector<float> gx_y;
  std::vector<float> gy_x;
  std::vector<float> gy_y;
  std::vector<float> ramp_x;  ///< x / radius
  std::vector<float> ramp_y;
  std::vector<float> value_ramp_x;
  std::vector<float> value_ramp_y;
  double mean = 0.0;      ///< of the values
  double contrast = 0.0;  ///< their standard deviation, or more where they stand for a pattern that varies more
  double radius = 1.0;    ///< of the farthest point from the origin

  PointArrays() = default;
  explicit PointArrays(const std::vector<PatternPoint>& points) { assign(points); }
  /// The same in the memory that is there.
  void assign(const std::vector<PatternPoint>& points);
};

/// Where points fall in a picture, as offsets from one of its pixels.
struct Places {
  int base_x = 0;
  int base_y = 0;
  std::vector<float> u;
  std::vector<float> v;
  std::vector<double> image_u;  ///< scratch of place()
  std::vector<double> image_v;
};

/// From pattern pixels to the pixels of one level of a picture, through pose and mapping.
struct Projection {
  const Mapping* mapping = nullptr;  ///< of the picture
  const Level* level = nullptr;
  double pitch = 1.0;  ///< plane units per pattern pixel

  /// Level coordinates of `count` pattern points.
  void level_from_pattern(const Pose& pose, const double* x, const double* y, int count, double* u, double* v) const;
  /// The same for the inner loops. Points that the mapping does not show get NaN.
  void place(const Pose& pose, const PointArrays& points, Places& places) const;
  /// Derivative of level coordinates by plane coordinates at a plane point.
  [[nodiscard]] Eigen::Matrix2d level_from_plane_jacobian(const Eigen::Vector2d& plane) const;
};

}  // namespace vsfind
