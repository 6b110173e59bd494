#include "calibration/lens.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "acquisition/errors.h"
#include "calibration/distortion.h"
#include "tests/calibration/cameras.h"

namespace vsfind {
namespace {

using test::lens_of;

TEST(Lens, ArcTangentIsTheLibrarys) {
  for (double x = 0.0; x < 600.0; x = x * 1.01 + 1e-4) {
    ASSERT_NEAR(distortion::arc_tangent(x), std::atan(x), 4e-16) << x;
  }
}

// Worked by hand from the formulas of lens.h at x = 0.3, y = -0.2, r² = 0.13.
TEST(Lens, FollowsTheWrittenFormulas) {
  const double x = 0.3, y = -0.2, r2 = 0.13, k1 = -0.3, k2 = 0.12, p1 = 1e-3, p2 = -5e-4, k3 = -0.05;
  const double f = 1 + k1 * r2 + k2 * r2 * r2 + k3 * r2 * r2 * r2;
  const Eigen::Vector2d brown(x * f + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
                              y * f + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y);
  const Eigen::Vector2d got = lens_of(LensModel::polynomial, {k1, k2, p1, p2, k3}).pixel_from_ray({x, y});
  EXPECT_NEAR(got.x(), 800.0 * brown.x() + 322.3, 1e-10);
  EXPECT_NEAR(got.y(), 790.0 * brown.y() + 236.1, 1e-10);
  const double r = std::sqrt(r2), t = std::atan(r);
  const double scale =
      t * (1 - 0.02 * std::pow(t, 2) + 0.01 * std::pow(t, 4) - 0.004 * std::pow(t, 6) + 0.001 * std::pow(t, 8)) / r;
  const Eigen::Vector2d fish = lens_of(LensModel::fisheye, {-0.02, 0.01, -0.004, 0.001}).pixel_from_ray({x, y});
  EXPECT_NEAR(fish.x(), 800.0 * x * scale + 322.3, 1e-10);
  EXPECT_NEAR(fish.y(), 790.0 * y * scale + 236.1, 1e-10);
}

TEST(Lens, EndsWhereThePolynomialTurnsBack) {
  // r (1 - r²/3) has its largest value 2/3 at r = 1.
  const Lens lens(LensModel::polynomial, {100.0, 100.0, 0.0, 0.0}, std::array{-1.0 / 3.0, 0.0, 0.0, 0.0});
  EXPECT_NEAR(lens.max_radius2(), 1.0, 1e-9);
  EXPECT_NEAR(lens.pixel_from_ray({0.99, 0.0}).x(), 100.0 * 0.99 * (1.0 - 0.99 * 0.99 / 3.0), 1e-9);
  EXPECT_TRUE(std::isnan(lens.pixel_from_ray({1.01, 0.0}).x()));
  EXPECT_TRUE(std::isnan(lens.pixel_from_ray({1.7, 0.0}).x())) << "this ray would come out near the middle";
  // r = 2 sin a turns the cubic into (2/3) sin 3a.
  EXPECT_NEAR(lens.ray_from_pixel({66.0, 0.0}).x(), 2.0 * std::sin(std::asin(0.99) / 3.0), 1e-11);
  EXPECT_TRUE(lens.ray_from_pixel({66.7, 0.0}).array().isNaN().all());
  EXPECT_TRUE(lens.ray_from_pixel({1e9, -1e9}).array().isNaN().all());
}

TEST(Lens, EndsBeforeAPole) {
  // The divisor 1 - r² is zero at r = 1; before it the factor only grows.
  const Lens lens(LensModel::polynomial, {100.0, 100.0, 0.0, 0.0}, std::array{0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0});
  EXPECT_LE(lens.max_radius2(), 1.0);
  EXPECT_GT(lens.max_radius2(), 0.99);
  EXPECT_TRUE(std::isnan(lens.pixel_from_ray({1.2, 0.0}).x()));
}

// Every pixel gets a ray that comes back to it, or NaN; no third way, whatever the coefficients.
TEST(Lens, NeverAnswersWrongly) {
  unsigned state = 1;
  const auto random = [&state] {
    state = state * 1664525U + 1013904223U;
    return static_cast<double>(state >> 8U) / 8388608.0 - 1.0;
  };
  int lifted = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    std::vector<double> k(std::array<std::size_t, 4>{4, 5, 8, 12}[static_cast<std::size_t>(trial) % 4]);
    for (double& value : k) value = random() * std::pow(10.0, 2.0 * random());
    if (trial % 2 == 0) k[2] = k[3] = 0.01 * random();
    const bool fisheye = k.size() == 4 && trial % 8 == 0;
    const Lens lens = lens_of(fisheye ? LensModel::fisheye : LensModel::polynomial, k);
    for (int i = 0; i < 10; ++i) {
      const Eigen::Vector2d pixel(320.0 + 700.0 * random(), 240.0 + 500.0 * random());
      const Eigen::Vector2d ray = lens.ray_from_pixel(pixel);
      if (ray.array().isNaN().all()) continue;
      ++lifted;
      ASSERT_TRUE(ray.allFinite());
      ASSERT_LT((lens.pixel_from_ray(ray) - pixel).norm(), 2e-10);
    }
  }
  EXPECT_GT(lifted, 5000);
}

TEST(Lens, RefusesBadNumbers) {
  const PinholeCamera good{800, 800, 320, 240};
  const std::vector<double> none;
  EXPECT_THROW(Lens(LensModel::polynomial, {0.0, 800, 320, 240}, none), UsageError);
  EXPECT_THROW(Lens(LensModel::polynomial, {800, -1.0, 320, 240}, none), UsageError);
  EXPECT_THROW(Lens(LensModel::polynomial, {800, 800, std::nan(""), 240}, none), UsageError);
  EXPECT_THROW(Lens(LensModel::polynomial, good, std::vector<double>(6)), UsageError);
  EXPECT_THROW(Lens(LensModel::polynomial, good, std::vector<double>(14)), UsageError);
  EXPECT_THROW(Lens(LensModel::fisheye, good, std::vector<double>(5)), UsageError);
  EXPECT_THROW(Lens(LensModel::polynomial, good, std::vector<double>{0, 0, 0, std::numeric_limits<double>::infinity()}),
               UsageError);
  EXPECT_NO_THROW(Lens(LensModel::polynomial, good, std::vector<double>(12)));
}

}  // namespace
}  // namespace vsfind
