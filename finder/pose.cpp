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

}  // namespace vsfind
