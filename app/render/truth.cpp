#include "app/render/truth.h"

#include <Eigen/LU>
#include <cmath>
#include <numbers>

namespace vsfind::render {
namespace {

constexpr double degrees = std::numbers::pi / 180.0;

Eigen::Matrix2d linear(const Pose& pose) {
  const double c = std::cos(pose.angle_deg * degrees);
  const double s = std::sin(pose.angle_deg * degrees);
  Eigen::Matrix2d turn;
  turn << c, -s, s, c;
  return turn * Eigen::Vector2d(pose.scale_x, pose.scale_y).asDiagonal();
}

/// Calls use(point) for a grid of about 4000 points of the box.
template <typename Use>
double part_of_box(const Drawing& drawing, Use use) {
  constexpr int steps = 64;
  int hits = 0;
  for (int i = 0; i < steps; ++i) {
    for (int k = 0; k < steps; ++k) {
      const Eigen::Vector2d point(((i + 0.5) / steps - 0.5) * drawing.width,
                                  ((k + 0.5) / steps - 0.5) * drawing.height);
      hits += use(point) ? 1 : 0;
    }
  }
  return static_cast<double>(hits) / (steps * steps);
}

}  // namespace

Pose expected_pose(const Pose& train, const Pose& scene, const Eigen::Vector2d& origin) {
  const Eigen::Matrix2d from_train = linear(scene) * linear(train).inverse();
  const Eigen::Vector2d place =
      Eigen::Vector2d(scene.x, scene.y) + from_train * (origin - Eigen::Vector2d(train.x, train.y));
  Pose pose;
  pose.x = place.x();
  pose.y = place.y();
  pose.angle_deg = std::atan2(from_train(1, 0), from_train(0, 0)) / degrees;
  pose.scale_x = from_train.col(0).norm();
  pose.scale_y = from_train.col(1).norm();
  return pose;
}

Eigen::Vector2d roi_centre(const Roi& roi) { return {roi.x + (roi.width - 1) / 2.0, roi.y + (roi.height - 1) / 2.0}; }

double angle_difference_deg(double a, double b) { return std::remainder(a - b, 360.0); }

bool inside(const Shape& shape, const Eigen::Vector2d& point) {
  bool in = false;
  for (const Contour& contour : shape.contours) {
    for (std::size_t i = 0; i < contour.size(); ++i) {
      const Eigen::Vector2d& a = contour[i];
      const Eigen::Vector2d& b = contour[(i + 1) % contour.size()];
      if ((a.y() > point.y()) == (b.y() > point.y())) continue;
      if (point.x() < a.x() + (b.x() - a.x()) * (point.y() - a.y()) / (b.y() - a.y())) in = !in;
    }
  }
  return in;
}

double hidden_part(const Drawing& drawing, const Drawing& cover) {
  return part_of_box(drawing, [&](const Eigen::Vector2d& point) {
    for (const Shape& shape : cover.shapes) {
      if (inside(shape, point)) return true;
    }
    return false;
  });
}

double outside_part(const Scene& scene, const Item& item) {
  return part_of_box(item.drawing, [&](const Eigen::Vector2d& point) {
    const Eigen::Vector2d p = frame_from_drawing(scene, item, point);
    return p.x() < -0.5 || p.y() < -0.5 || p.x() > scene.width - 0.5 || p.y() > scene.height - 0.5;
  });
}

}  // namespace vsfind::render
