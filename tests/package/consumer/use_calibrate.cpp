// The homography of four points that a plain scaling by two and a shift explains.
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdio>

#include "calibration/plane_fit.h"

int main() {
  const std::array<Eigen::Vector2d, 4> plane{{{0, 0}, {10, 0}, {10, 10}, {0, 10}}};
  std::array<Eigen::Vector2d, 4> image;
  for (std::size_t i = 0; i < plane.size(); ++i) image[i] = 2.0 * plane[i] + Eigen::Vector2d(5, 7);
  const Eigen::Matrix3d h = vsfind::fit_homography(plane, image);
  const Eigen::Vector2d middle = (h * Eigen::Vector3d(5, 5, 1)).hnormalized();
  if ((middle - Eigen::Vector2d(15, 17)).norm() > 1e-6) {
    std::fprintf(stderr, "the middle is at %.6f %.6f instead of 15 17\n", middle.x(), middle.y());
    return 1;
  }
  return 0;
}
