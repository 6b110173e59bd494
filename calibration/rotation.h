#pragma once
/// @file
/// Rotation matrices and rotation vectors (axis times angle in radians; Rodrigues 1840).

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace vsfind {

[[nodiscard]] inline Eigen::Matrix3d rotation_from_vector(const Eigen::Vector3d& vector) {
  const double angle = vector.norm();
  if (!(angle > 0.0)) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, vector / angle).toRotationMatrix();
}

[[nodiscard]] inline Eigen::Vector3d vector_from_rotation(const Eigen::Matrix3d& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return turn.angle() * turn.axis();
}

}  // namespace vsfind
