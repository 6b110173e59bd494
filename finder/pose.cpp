#include "finder/pose.h"

#include <cmath>
#include <numbers>

namespace vsfind {

Eigen::Vector2d plane_from_pattern(const Pose& pose, const Eigen::Vector2d& from_origin) {
  const double angle = pose.angle_deg * std::numbers::pi / 180.0;
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  const double u = pose.scale_x * from_origin.x();
  const double v = pose.scale_y * from_origin.y();
  return {pose.x + c * u - s * v, pose.y + s * u + c * v};
}

double angle_between(double a_deg, double b_deg) { return std::abs(std::remainder(a_deg - b_deg, 360.0)); }

bool precedes(const Pose& a, const Pose& b) {
  return a.y != b.y ? a.y < b.y : a.x != b.x ? a.x < b.x : a.angle_deg < b.angle_deg;
}

}  // namespace vsfind
