#include "finder/points.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "finder/reading_kernels.h"

namespace vsfind {

void PointArrays::assign(const std::vector<PatternPoint>& points) {
  count = static_cast<int>(points.size());
  const auto n = static_cast<double>(std::max(1, count));
  mean = contrast = 0.0;
  radius = 1.0;
  middle.setZero();
  for (const PatternPoint& point : points) {
    mean += static_cast<double>(point.value) / n;
    middle += Eigen::Vector2d(point.x, point.y) / n;
    radius = std::max(radius, point.x * point.x + point.y * point.y);
  }
  radius = std::sqrt(radius);
  for (const PatternPoint& point : points) {
    const double off = static_cast<double>(point.value) - mean;
    contrast += off * off / n;
  }
  contrast = std::sqrt(contrast);
  const auto padded = static_cast<std::size_t>(kernels::padded(count));
  for (std::vector<double>* each : {&x, &y}) each->assign(padded, 0.0);
  for (std::vector<float>* each :
       {&near_x, &near_y, &value, &one, &gradient_x, &gradient_y, &laplacian, &stretch, &shear, &gx_x, &gx_y, &gy_x,
        &gy_y, &ramp_x, &ramp_y, &value_ramp_x, &value_ramp_y}) {
    each->assign(padded, 0.0F);
  }
  for (std::size_t k = 0; k < points.size(); ++k) {
    const PatternPoint& point = points[k];
    const auto gx = static_cast<double>(point.gradient_x);
    const auto gy = static_cast<double>(point.gradient_y);
    const double off = static_cast<double>(point.value) - mean;
    const double part_x = point.x / radius;
    const double part_y = point.y / radius;
    x[k] = point.x;
    y[k] = point.y;
    near_x[k] = static_cast<float>(point.x - middle.x());
    near_y[k] = static_cast<float>(point.y - middle.y());
    value[k] = static_cast<float>(off);
    one[k] = 1.0F;
    gradient_x[k] = point.gradient_x;
    gradient_y[k] = point.gradient_y;
    laplacian[k] = point.laplacian;
    stretch[k] = point.stretch;
    shear[k] = point.shear;
    gx_x[k] = static_cast<float>(gx * part_x);
    gx_y[k] = static_cast<float>(gx * part_y);
    gy_x[k] = static_cast<float>(gy * part_x);
    gy_y[k] = static_cast<float>(gy * part_y);
    ramp_x[k] = static_cast<float>(part_x);
    ramp_y[k] = static_cast<float>(part_y);
    value_ramp_x[k] = static_cast<float>(off * part_x);
    value_ramp_y[k] = static_cast<float>(off * part_y);
  }
}

Eigen::Matrix2d Projection::level_from_plane_jacobian(const Eigen::Vector2d& plane) const {
  Eigen::Matrix2d jacobian = mapping->image_from_plane_jacobian(plane);
  jacobian.row(0) /= level->step_x;
  jacobian.row(1) /= level->step_y;
  return jacobian;
}

namespace {

/// Plane coordinates from pattern pixels, without the shift.
Eigen::Matrix2d turn_of(const Pose& pose, double pitch) {
  const double angle = pose.angle_deg * std::numbers::pi / 180.0;
  const double c = std::cos(angle) * pitch;
  const double s = std::sin(angle) * pitch;
  Eigen::Matrix2d turn;
  turn << c * pose.scale_x, -s * pose.scale_y, s * pose.scale_x, c * pose.scale_y;
  return turn;
}

}  // namespace

void Projection::level_from_pattern(const Pose& pose, const double* x, const double* y, int count, double* u,
                                    double* v) const {
  const Eigen::Matrix2d turn = turn_of(pose, pitch);
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

void Projection::place(const Pose& pose, const PointArrays& points, Places& places) const {
  const std::size_t n = points.x.size();
  places.u.resize(n);
  places.v.resize(n);
  const Eigen::Matrix2d turn = turn_of(pose, pitch);
  const Eigen::Vector2d plane(pose.x, pose.y);
  const Eigen::Vector2d middle = level->level_from_image(mapping->image_from_plane(plane + turn * points.middle));
  // Far outside any picture, or not shown at all: nothing will be read.
  constexpr double farthest = 1e6;
  if (!(std::abs(middle.x()) < farthest && std::abs(middle.y()) < farthest)) {
    std::fill(places.u.begin(), places.u.end(), std::nanf(""));
    std::fill(places.v.begin(), places.v.end(), std::nanf(""));
    return;
  }
  places.base_x = static_cast<int>(std::lround(middle.x()));
  places.base_y = static_cast<int>(std::lround(middle.y()));
  if (mapping->affine()) {
    const Eigen::Matrix2d m = level_from_plane_jacobian(plane) * turn;
    const float line[6] = {
        static_cast<float>(m(0, 0)), static_cast<float>(m(0, 1)), static_cast<float>(middle.x() - places.base_x),
        static_cast<float>(m(1, 0)), static_cast<float>(m(1, 1)), static_cast<float>(middle.y() - places.base_y)};
    kernels::project(points.near_x.data(), points.near_y.data(), points.count, line, places.u.data(), places.v.data());
    return;
  }
  places.image_u.resize(n);
  places.image_v.resize(n);
  mapping->image_from_local({turn, plane}, points.x, points.y, places.image_u, places.image_v);
  const double per_x = 1.0 / level->step_x;
  const double per_y = 1.0 / level->step_y;
  const double from_x = -level->offset_x * per_x - places.base_x;
  const double from_y = -level->offset_y * per_y - places.base_y;
  for (std::size_t i = 0; i < n; ++i) {
    places.u[i] = static_cast<float>(places.image_u[i] * per_x + from_x);
    places.v[i] = static_cast<float>(places.image_v[i] * per_y + from_y);
  }
}

}  // namespace vsfind
