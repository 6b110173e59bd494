/// Photographs are resampled where they are said to be.
#include "render/photo.h"

#include <gtest/gtest.h>

#include <cmath>

#include "app/render/sensor.h"

namespace vsfind::render {
namespace {

/// A bright spot of Gaussian shape at (61.3, 47.8), as a photograph.
Picture spot() {
  Picture picture(128, 96, 16);
  for (int y = 0; y < 96; ++y) {
    for (int x = 0; x < 128; ++x) {
      const double r2 = std::pow(x - 61.3, 2) + std::pow(y - 47.8, 2);
      picture.set(x, y, static_cast<int>(256.0 * 200.0 * std::exp(-r2 / (2.0 * 25.0)) + 0.5));
    }
  }
  return picture;
}

TEST(Photo, PointsGoWhereThePoseSays) {
  const Photo photo(spot().view());
  const Eigen::Vector2d centre(55.0, 40.0);
  const Pose pose{30.4, 26.7, 25.0, 1.1, 0.95};
  const Exposure e = expose_photo(photo, centre, 2.0, pose, 70, 60);
  double mass = 0.0;
  Eigen::Vector2d sum(0, 0);
  for (int y = 0; y < e.height; ++y) {
    for (int x = 0; x < e.width; ++x) {
      mass += static_cast<double>(e.at(x, y));
      sum += static_cast<double>(e.at(x, y)) * Eigen::Vector2d(x, y);
    }
  }
  const Eigen::Vector2d expected = plane_from_pattern(pose, (Eigen::Vector2d(61.3, 47.8) - centre) / 2.0);
  EXPECT_NEAR(sum.x() / mass, expected.x(), 1e-3);
  EXPECT_NEAR(sum.y() / mass, expected.y(), 1e-3);
}

TEST(Photo, RichestRoiHoldsTheStructure) {
  const Photo photo(spot().view());
  const Exposure e = expose_photo(photo, {63.5, 47.5}, 1.0, {63.5, 47.5, 0, 1, 1}, 128, 96);
  const Roi roi = richest_roi(e, 40, 4);
  EXPECT_EQ(roi.width, 40);
  EXPECT_NEAR(roi.x + 19.5, 61.3, 5.0);
  EXPECT_NEAR(roi.y + 19.5, 47.8, 5.0);
}

}  // namespace
}  // namespace vsfind::render
