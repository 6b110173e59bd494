#pragma once
// The cameras that the tests look through: 640x480, a board some 500 mm away, straight or at a slant.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <numbers>
#include <string>
#include <vector>

#include "calibration/mapping.h"

namespace vsfind::test {

inline double radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

/// A plane whose point (0, 0) is `distance` away on the axis, turned about camera x, then y, then z.
inline PlanePose slanted_plane(double about_x_deg, double about_y_deg, double about_z_deg, double distance) {
  PlanePose pose;
  pose.rotation = (Eigen::AngleAxisd(radians(about_z_deg), Eigen::Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(radians(about_y_deg), Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(radians(about_x_deg), Eigen::Vector3d::UnitX()))
                      .toRotationMatrix();
  pose.translation = {0.0, 0.0, distance};
  return pose;
}

struct NamedMapping {
  std::string name;
  Mapping mapping;
};

inline Lens lens_of(LensModel model, std::vector<double> coefficients) {
  return Lens(model, {800.0, 790.0, 322.3, 236.1}, coefficients);
}

/// One of each kind. Barrel distortion of about 5% of the width where it bends.
inline std::vector<NamedMapping> all_kinds() {
  const PlanePose slanted = slanted_plane(35.0, 5.0, 10.0, 500.0);
  Eigen::Matrix3d homography;
  homography << 1.7, 0.2, 310.0, -0.15, 1.4, 250.0, 1.1e-4, -7e-4, 1.0;
  Eigen::Matrix3d flat;
  flat << 3.0, 0.2, 300.0, -0.1, 2.9, 200.0, 0.0, 0.0, 2.0;
  return {
      {"plain", Mapping()},
      {"aspect", Mapping::from_pixel_aspect(59.0 / 54.0)},
      {"flat", Mapping::from_homography(flat)},
      {"homography", Mapping::from_homography(homography)},
      {"pinhole", Mapping::from_lens(lens_of(LensModel::polynomial, {}), slanted)},
      {"plumb_bob 4", Mapping::from_lens(lens_of(LensModel::polynomial, {-0.3, 0.12, 1e-3, -5e-4}), slanted)},
      {"plumb_bob 5", Mapping::from_lens(lens_of(LensModel::polynomial, {-0.3, 0.12, 1e-3, -5e-4, -0.05}), slanted)},
      {"pincushion", Mapping::from_lens(lens_of(LensModel::polynomial, {0.25, 0.1, 1e-3, -5e-4, 0.02}), slanted)},
      {"rational 8",
       Mapping::from_lens(lens_of(LensModel::polynomial, {0.6, -0.2, 8e-4, 3e-4, 0.03, 0.9, 0.05, 0.01}), slanted)},
      {"thin prism 12", Mapping::from_lens(lens_of(LensModel::polynomial, {-0.2, 0.1, 8e-4, 3e-4, 0.0, 0.1, 0.05, 0.0,
                                                                           2e-3, -1e-3, 1e-3, 5e-4}),
                                           slanted)},
      {"fisheye", Mapping::from_lens(lens_of(LensModel::fisheye, {-0.02, 0.01, -0.004, 0.001}), slanted)},
  };
}

}  // namespace vsfind::test
