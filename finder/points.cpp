#include "finder/points.h"

#include <cmath>
#include <numbers>

namespace vsfind {

PointArrays::PointArrays(const std::vector<PatternPoint>& points) {
  for (const PatternPoint& point : points) {
    x.push_back(point.x);
    y.push_back(point.y);
    value.push_back(static_cast<double>(point.value));
    gradient_x.push_back(static_cast<double>(point.gradient_x));
    gradient_y.push_back(static_cast<double>(point.gradient_y));
    laplacian.push_back(static_cast<double>(point.laplacian));
  }
}

Eigen::Matrix2d Projection::level_from_plane_jacobian(const Eigen::Vector2d& plane) const {
  Eigen::Matrix2d jacobian = mapping->image_from_plane_jacobian(plane);
  jacobian.row(0) /= level->step_x;
  jacobian.row(1) /= level->step_y;
  return jacobian;
}

void Projection::level_from_pattern(const Pose& pose, const double* x, const double* y, int count, double* u,
                                    double* v) const {
  const double angle = pose.angle_deg * std::numbers::pi / 180.0;
  const double c = std::cos(angle) * pitch;
  const double s = std::sin(angle) * pitch;
  Eigen::Matrix2d turn;
  turn << c * pose.scale_x, -s * pose.scale_y, s * pose.scale_x, c * pose.scale_y;
  const Eigen::Vector2d plane(pose.x, pose.y);
  if (mapping->affine()) {
    const Eigen::Matrix2d m = level_from_plane_jacobian(plane) * turn;
    const Eigen::Vector2d p = level->level_from_image(mapping->image_from_plane(plane));
    for (int i = 0; i < count; ++i) {
      u[i] = p.x() + m(0, 0) * x[i] + m(0, 1) * y[i];
      v[i] = p.y() + m(1, 0) * x[i] + m(1, 1) * y[i];
    }
    return;
  }
  const auto n = static_cast<std::size_t>(count);
  mapping->image_from_local({turn, plane}, {x, n}, {y, n}, {u, n}, {v, n});
  const double per_x = 1.0 / level->step_x;
  const double per_y = 1.0 / level->step_y;
  for (std::size_t i = 0; i < n; ++i) {
    u[i] = (u[i] - level->offset_x) * per_x;
    v[i] = (v[i] - level->offset_y) * per_y;
  }
}

}  // namespace vsfind
