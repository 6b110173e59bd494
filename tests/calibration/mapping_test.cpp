#include "calibration/mapping.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

#include "acquisition/errors.h"
#include "tests/calibration/cameras.h"

namespace vsfind {
namespace {

using test::all_kinds;
using test::NamedMapping;

constexpr Field fields[] = {Field::frame, Field::top, Field::bottom};

TEST(Mapping, LiftsWhatItProjects) {
  for (const auto& [name, whole] : all_kinds()) {
    for (const Field field : fields) {
      const Mapping mapping = whole.for_field(field);
      SCOPED_TRACE(name + " " + vsfind::name(field));
      const double height = field == Field::frame ? 480.0 : 240.0;
      for (double y = 0.0; y < height; y += height / 12.3) {
        for (double x = 0.0; x < 640.0; x += 37.7) {
          const Eigen::Vector2d image(x, y);
          const Eigen::Vector2d again = mapping.image_from_plane(mapping.plane_from_image(image));
          ASSERT_LT((again - image).norm(), 2e-10) << image.transpose() << " came back as " << again.transpose();
        }
      }
    }
  }
}

TEST(Mapping, JacobianIsTheSlopeOfTheProjection) {
  for (const auto& [name, whole] : all_kinds()) {
    for (const Field field : fields) {
      const Mapping mapping = whole.for_field(field);
      SCOPED_TRACE(name + " " + vsfind::name(field));
      for (const Eigen::Vector2d& image : {Eigen::Vector2d(10, 8), {320, 118}, {600, 200}, {322.3, 236.1}}) {
        const Eigen::Vector2d plane = mapping.plane_from_image(image);
        const Eigen::Matrix2d j = mapping.image_from_plane_jacobian(plane);
        const double h = 1e-3;
        for (int axis = 0; axis < 2; ++axis) {
          const Eigen::Vector2d step = h * Eigen::Vector2d::Unit(axis);
          const Eigen::Vector2d slope =
              (mapping.image_from_plane(plane + step) - mapping.image_from_plane(plane - step)) / (2.0 * h);
          EXPECT_LT((slope - j.col(axis)).norm(), 2e-8 * j.norm()) << "axis " << axis << " at " << image.transpose();
        }
      }
    }
  }
}

TEST(Mapping, FieldsSeeTheFramesLines) {
  for (const auto& [name, mapping] : all_kinds()) {
    SCOPED_TRACE(name);
    const Eigen::Vector2d plane = mapping.plane_from_image({123.0, 45.0});
    const Eigen::Vector2d top = mapping.for_field(Field::top).image_from_plane(plane);
    const Eigen::Vector2d bottom = mapping.for_field(Field::bottom).image_from_plane(plane);
    EXPECT_NEAR(top.x(), 123.0, 1e-9);
    EXPECT_NEAR(top.y(), 22.5, 1e-9);
    EXPECT_NEAR(bottom.y(), 22.0, 1e-9);
    EXPECT_EQ(mapping.for_field(Field::top).for_field(Field::frame).image_from_plane(plane),
              mapping.image_from_plane(plane));
  }
}

TEST(Mapping, PlainPixelsStayExactly) {
  const Mapping plain;
  const Eigen::Vector2d p(123.456, 789.123);
  EXPECT_EQ(plain.plane_from_image(p), p);
  EXPECT_EQ(plain.image_from_plane(p), p);
  EXPECT_TRUE(plain.affine());
  const Mapping pal = Mapping::from_pixel_aspect(59.0 / 54.0);
  EXPECT_DOUBLE_EQ(pal.plane_from_image({54.0, 7.0}).x(), 59.0);
  EXPECT_TRUE(pal.affine());
  for (const auto& [name, mapping] : all_kinds()) {
    EXPECT_EQ(mapping.affine(), name == "plain" || name == "aspect" || name == "flat") << name;
  }
}

TEST(Mapping, ManyPointsAreTheSameAsOneByOne) {
  for (const auto& [name, whole] : all_kinds()) {
    for (const Field field : fields) {
      const Mapping mapping = whole.for_field(field);
      SCOPED_TRACE(name + " " + vsfind::name(field));
      PlaneFromLocal pose;
      pose.linear << 0.8, -0.3, 0.3, 0.8;
      pose.offset = mapping.plane_from_image({300.0, 100.0});
      for (const std::size_t count : {0U, 1U, 7U, 64U}) {
        std::vector<double> x(count), y(count), u(count), v(count);
        std::vector<float> xf(count), yf(count), uf(count), vf(count);
        for (std::size_t i = 0; i < count; ++i) {
          xf[i] = static_cast<float>(x[i] = 40.0 * std::sin(1.0 + static_cast<double>(i)));
          yf[i] = static_cast<float>(y[i] = 40.0 * std::cos(2.0 * static_cast<double>(i)));
        }
        mapping.image_from_local(pose, x, y, u, v);
        mapping.image_from_local(pose, xf, yf, uf, vf);
        for (std::size_t i = 0; i < count; ++i) {
          const Eigen::Vector2d plane = pose.linear * Eigen::Vector2d(x[i], y[i]) + pose.offset;
          const Eigen::Vector2d expected = mapping.image_from_plane(plane);
          ASSERT_NEAR(u[i], expected.x(), 1e-10);
          ASSERT_NEAR(v[i], expected.y(), 1e-10);
          ASSERT_NEAR(uf[i], expected.x(), 1e-4);
          ASSERT_NEAR(vf[i], expected.y(), 1e-4);
        }
        mapping.image_from_plane(x, y, u, v);
        for (std::size_t i = 0; i < count; ++i) {
          ASSERT_NEAR(u[i], mapping.image_from_plane(Eigen::Vector2d(x[i], y[i])).x(), 1e-10);
        }
      }
    }
  }
  std::vector<double> two(2), three(3), u(3), v(3);
  EXPECT_THROW(Mapping().image_from_plane(two, three, u, v), UsageError);
}

TEST(Mapping, BehindTheCameraIsNowhere) {
  const Lens lens = test::lens_of(LensModel::polynomial, {-0.3, 0.12, 0.0, 0.0});
  // The plane falls away: its horizon runs through the picture.
  const Mapping steep = Mapping::from_lens(lens, test::slanted_plane(-85.0, 0.0, 0.0, 500.0));
  const Eigen::Vector2d behind(0.0, 600.0);
  const Eigen::Vector2d visible(0.0, -600.0);
  ASSERT_TRUE(steep.image_from_plane(visible).allFinite());
  EXPECT_TRUE(steep.image_from_plane(behind).array().isNaN().all());
  EXPECT_TRUE(steep.image_from_plane_jacobian(behind).array().isNaN().all());
  const bool above = steep.plane_from_image({320.0, 0.0}).array().isNaN().all();
  const bool below = steep.plane_from_image({320.0, 479.0}).array().isNaN().all();
  EXPECT_NE(above, below) << "one side of the horizon sees the plane, the other does not";

  Eigen::Matrix3d h;
  h << 1, 0, 320, 0, 1, 240, 0, 1e-2, 1;
  const Mapping homography = Mapping::from_homography(h);
  EXPECT_TRUE(homography.image_from_plane(Eigen::Vector2d(0.0, -101.0)).array().isNaN().all());
  EXPECT_TRUE(homography.image_from_plane(Eigen::Vector2d(0.0, 100.0)).allFinite());

  for (const Mapping& mapping : {steep, homography}) {
    std::vector<double> x{0.0, 0.0, 0.0}, y{600.0, -600.0, -101.0}, u(3), v(3);
    mapping.image_from_plane(x, y, u, v);
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Vector2d one = mapping.image_from_plane(Eigen::Vector2d(x[i], y[i]));
      EXPECT_EQ(std::isnan(u[i]), std::isnan(one.x())) << i;
      EXPECT_EQ(std::isnan(v[i]), std::isnan(one.y())) << i;
    }
  }
}

// Far out the polynomial would bring points back into the picture.
TEST(Mapping, BeyondTheLensIsNowhere) {
  const Lens lens = test::lens_of(LensModel::polynomial, {-0.3, 0.0, 0.0, 0.0});
  const Mapping mapping = Mapping::from_lens(lens, test::slanted_plane(20.0, 0.0, 0.0, 500.0));
  std::vector<double> x{0.0, 300.0, 900.0, -1500.0}, y(4, 0.0), u(4), v(4);
  mapping.image_from_plane(x, y, u, v);
  for (std::size_t i = 0; i < x.size(); ++i) {
    const bool beyond = std::abs(x[i]) > 600.0;
    EXPECT_EQ(std::isnan(u[i]), beyond) << x[i];
    EXPECT_EQ(std::isnan(v[i]), beyond) << x[i];
    EXPECT_EQ(mapping.image_from_plane(Eigen::Vector2d(x[i], y[i])).array().isNaN().all(), beyond) << x[i];
    EXPECT_EQ(mapping.image_from_plane_jacobian(Eigen::Vector2d(x[i], y[i])).array().isNaN().all(), beyond) << x[i];
  }
}

TEST(Mapping, RefusesWhatIsNoMapping) {
  EXPECT_THROW((void)Mapping::from_pixel_aspect(0.0), UsageError);
  EXPECT_THROW((void)Mapping::from_pixel_aspect(std::nan("")), UsageError);
  Eigen::Matrix3d h = Eigen::Matrix3d::Identity();
  EXPECT_NO_THROW((void)Mapping::from_homography(h));
  h.row(1) = 2.0 * h.row(0);
  EXPECT_THROW((void)Mapping::from_homography(h), UsageError);
  h(0, 0) = std::numeric_limits<double>::infinity();
  EXPECT_THROW((void)Mapping::from_homography(h), UsageError);
  PlanePose pose;
  EXPECT_NO_THROW((void)Mapping::from_lens(Lens(), pose));
  pose.translation = {1.0, 1.0, 0.0};
  EXPECT_THROW((void)Mapping::from_lens(Lens(), pose), UsageError);
  pose.translation = {0.0, 0.0, 1.0};
  pose.rotation(0, 0) = -1.0;
  EXPECT_THROW((void)Mapping::from_lens(Lens(), pose), UsageError);
}

// The batch form exists for its speed. The figures are printed for the eyes.
TEST(Mapping, ManyPointsCostLessThanOneByOne) {
  constexpr std::size_t count = 400;
  std::vector<double> x(count), y(count), u(count), v(count);
  for (std::size_t i = 0; i < count; ++i) {
    x[i] = 40.0 * std::sin(1.0 + static_cast<double>(i));
    y[i] = 40.0 * std::cos(2.0 * static_cast<double>(i));
  }
  const auto best_of = [](const auto& work) {
    double best = 1e9;
    for (int round = 0; round < 200; ++round) {
      const auto start = std::chrono::steady_clock::now();
      work();
      const std::chrono::duration<double, std::nano> spent = std::chrono::steady_clock::now() - start;
      best = std::min(best, spent.count() / count);
    }
    return best;
  };
  for (const auto& [name, mapping] : all_kinds()) {
    const double together = best_of([&, &m = mapping] { m.image_from_plane(x, y, u, v); });
    const double one_by_one = best_of([&, &m = mapping] {
      for (std::size_t i = 0; i < count; ++i) {
        const Eigen::Vector2d p = m.image_from_plane(Eigen::Vector2d(x[i], y[i]));
        u[i] = p.x();
        v[i] = p.y();
      }
    });
    std::printf("%-14s %.2f ns per point, one by one %.2f\n", name.c_str(), together, one_by_one);
    EXPECT_LT(together, one_by_one) << name;
  }
}

}  // namespace
}  // namespace vsfind
