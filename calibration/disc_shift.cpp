#include "calibration/disc_shift.h"

#include <Eigen/LU>
#include <cmath>
#include <numbers>

namespace vsfind {

Eigen::Vector2d disc_shift(const Mapping& mapping, const Eigen::Vector2d& centre, double radius) {
  // Equal areas of the disc: rings at the middle of each part of r², spokes at equal angles. Each counts as much image
  // as it covers. What is left of the rings' error is of the fourth order in the radius.
  constexpr int rings = 6;
  constexpr int spokes = 12;
  double area = 0.0;
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  const Eigen::Vector2d middle = mapping.image_from_plane(centre);
  for (int ring = 0; ring < rings; ++ring) {
    const double r = radius * std::sqrt((ring + 0.5) / rings);
    for (int spoke = 0; spoke < spokes; ++spoke) {
      const double angle = 2.0 * std::numbers::pi * (spoke + 0.5 * (ring % 2)) / spokes;
      const Eigen::Vector2d plane = centre + r * Eigen::Vector2d(std::cos(angle), std::sin(angle));
      const double part = std::abs(mapping.image_from_plane_jacobian(plane).determinant());
      area += part;
      moment += part * (mapping.image_from_plane(plane) - middle);
    }
  }
  return moment / area;
}

double disc_radius(const Mapping& mapping, const Eigen::Vector2d& centre, double area) {
  const double scale = std::abs(mapping.image_from_plane_jacobian(centre).determinant());
  return std::sqrt(area / (std::numbers::pi * scale));
}

}  // namespace vsfind
