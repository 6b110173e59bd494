/// The finder's smaller parts: pyramid, coarse grid, readers, polygons, threads.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <numeric>

#include "finder/coarse_grid.h"
#include "finder/informative_points.h"
#include "finder/prepared_pattern.h"
#include "finder/pyramid.h"
#include "finder/sampling.h"
#include "finder/thread_pool.h"

namespace vsfind {
namespace {

ImageView view_of(const std::vector<std::uint8_t>& pixels, int width, int height) {
  return {reinterpret_cast<const std::byte*>(pixels.data()), width, height, width, 8};
}

/// A ramp: its value tells where it was read.
std::vector<std::uint8_t> ramp(int width, int height, int along_x, int along_y) {
  std::vector<std::uint8_t> pixels;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) pixels.push_back(static_cast<std::uint8_t>(along_x * x + along_y * y));
  }
  return pixels;
}

TEST(Pyramid, LevelsKnowWhereTheirPixelsLie) {
  const auto pixels = ramp(64, 32, 2, 3);
  Pyramid pyramid;
  pyramid.build(view_of(pixels, 64, 32), HalvingPlan::for_pixel_size(1.0, 1.0, 2));
  ASSERT_EQ(pyramid.levels(), 3);
  for (int index = 0; index < 3; ++index) {
    const Level& level = pyramid.level(index);
    const Eigen::Vector2d at = level.image_from_level({5, 3});
    EXPECT_NEAR(level.row(3)[5], 2.0 * at.x() + 3.0 * at.y(), 0.75) << "level " << index;
    const Level& smoothed = pyramid.smoothed(index);
    EXPECT_NEAR(smoothed.row(3)[5], 2.0 * at.x() + 3.0 * at.y(), 0.75) << "smoothed level " << index;
  }
}

TEST(Pyramid, FieldIsHalvedAlongXFirst) {
  const HalvingPlan plan = HalvingPlan::for_pixel_size(1.0, 2.0, 3);
  EXPECT_TRUE(plan.steps[0].x);
  EXPECT_FALSE(plan.steps[0].y);
  EXPECT_TRUE(plan.steps[1].x && plan.steps[1].y);
  const auto pixels = ramp(64, 32, 2, 4);
  Pyramid pyramid;
  pyramid.build(view_of(pixels, 64, 32), plan);
  const Level& level = pyramid.level(1);
  EXPECT_EQ(level.width, 32);
  EXPECT_EQ(level.height, 32);
  EXPECT_DOUBLE_EQ(level.offset_x, 0.5);
  EXPECT_DOUBLE_EQ(level.offset_y, 0.0);
}

TEST(Pyramid, KeepsTheUpperBitsOfDeepPictures) {
  std::vector<std::uint16_t> deep(16 * 16, 0x0ABC);
  const ImageView view{reinterpret_cast<const std::byte*>(deep.data()), 16, 16, 32, 12};
  Pyramid pyramid;
  pyramid.build(view, HalvingPlan::for_pixel_size(1.0, 1.0, 1));
  EXPECT_EQ(pyramid.level(0).row(2)[3], 0xAB);
  EXPECT_EQ(pyramid.level(1).row(2)[3], 0xAB);
}

TEST(CoarseGrid, CoversTheRangeWithinHalfAStep) {
  const auto centres = cell_centres({-45.0, 45.0}, 5.9);
  EXPECT_EQ(centres.size(), 16U);
  for (double angle = -45.0; angle <= 45.0; angle += 0.1) {
    double nearest = 1e9;
    for (const double centre : centres) nearest = std::min(nearest, std::abs(centre - angle));
    EXPECT_LE(nearest, 5.9 / 2.0 + 1e-9);
  }
  EXPECT_EQ(cell_centres({7.0, 7.0}, 1.0), std::vector<double>{7.0});
}

TEST(CoarseGrid, CommonScaleIsOneDimension) {
  CoarseGrid grid{{0.0, 0.0}, {0.8, 1.25}, {0.8, 1.25}, true, 0.0, 0.1};
  for (const Hypothesis& each : hypotheses(grid)) EXPECT_EQ(each.scale_x, each.scale_y);
  const std::size_t alike = hypotheses(grid).size();
  grid.common_scale = false;
  EXPECT_EQ(hypotheses(grid).size(), alike * alike);
}

TEST(GaussianReader, ReadsARampExactlyAndRefusesTheBorder) {
  const auto pixels = ramp(40, 30, 3, 4);
  const GaussianReader reader(view_of(pixels, 40, 30), 1.0, 1.0);
  double out[4];
  ASSERT_TRUE(reader.read_with_derivatives(15.4, 12.7, out));
  EXPECT_NEAR(out[0], 3.0 * 15.4 + 4.0 * 12.7, 0.01);
  EXPECT_NEAR(out[1], 3.0, 0.02);
  EXPECT_NEAR(out[2], 4.0, 0.02);
  for (const auto& [u, v] : {std::pair(2.9, 12.0), {36.1, 12.0}, {15.0, 2.9}, {15.0, 26.1}, {std::nan(""), 12.0}}) {
    double value = -1.0;
    double inside = -1.0;
    reader.read(&u, &v, 1, &value, &inside);
    EXPECT_EQ(inside, 0.0) << u << ' ' << v;
  }
}

TEST(GaussianReader, DeepPicturesAreScaledLikeEightBits) {
  std::vector<std::uint16_t> deep(16 * 16, 100U << 4U);
  const GaussianReader reader({reinterpret_cast<const std::byte*>(deep.data()), 16, 16, 32, 12}, 1.0, 1.0);
  const double at = 8.0;
  double value = 0.0;
  double inside = 0.0;
  reader.read(&at, &at, 1, &value, &inside);
  EXPECT_NEAR(value, 100.0, 1e-9);
}

Polygon polygon(std::initializer_list<Eigen::Vector2d> corners) {
  Polygon all;
  for (const Eigen::Vector2d& corner : corners) all.add(corner);
  return all;
}

TEST(Polygons, SharedAreaOfTurnedSquares) {
  const Polygon square = polygon({{0, 0}, {2, 0}, {2, 2}, {0, 2}});
  const Polygon shifted = polygon({{1, 1}, {3, 1}, {3, 3}, {1, 3}});
  const Polygon far = polygon({{5, 5}, {6, 5}, {6, 6}, {5, 6}});
  EXPECT_DOUBLE_EQ(area(square), 4.0);
  EXPECT_DOUBLE_EQ(shared_area(square, shifted), 1.0);
  EXPECT_DOUBLE_EQ(shared_area(square, square), 4.0);
  EXPECT_DOUBLE_EQ(shared_area(square, far), 0.0);
}

TEST(InformativePoints, RotationSendsThemFarOut) {
  // A vertical edge: with an angle to be found its ends tell most, without one any part of it tells the same.
  std::vector<PatternPoint> edge;
  for (int y = -50; y <= 50; ++y) edge.push_back({0.0, static_cast<double>(y), 100.0F, 30.0F, 0.1F, 0.0F});
  Freedom turned;
  turned.angle = true;
  double mean_turned = 0.0;
  double mean_still = 0.0;
  for (const std::size_t k : choose_informative(edge, turned, 20, 2.0, false))
    mean_turned += std::abs(edge[k].y) / 20.0;
  for (const std::size_t k : choose_informative(edge, {}, 20, 2.0, false)) mean_still += std::abs(edge[k].y) / 20.0;
  EXPECT_GT(mean_turned, 35.0);
  EXPECT_LT(mean_still, 35.0);
}

TEST(InformativePoints, KeepTheirDistance) {
  std::vector<PatternPoint> grid;
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 30; ++x) {
      grid.push_back({static_cast<double>(x), static_cast<double>(y), 0.0F, static_cast<float>(x % 7), 3.0F, 0.0F});
    }
  }
  const auto chosen = choose_informative(grid, {}, 60, 3.0, false);
  EXPECT_EQ(chosen.size(), 60U);
  for (std::size_t a = 0; a < chosen.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      EXPECT_GE(std::hypot(grid[chosen[a]].x - grid[chosen[b]].x, grid[chosen[a]].y - grid[chosen[b]].y), 2.99);
    }
  }
}

TEST(ThreadPool, RunsEveryShareOnceAndWaits) {
  for (const int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    std::vector<std::atomic<int>> runs(static_cast<std::size_t>(threads));
    for (int round = 0; round < 50; ++round) {
      pool.run([&](int i) { ++runs[static_cast<std::size_t>(i)]; });
      for (const auto& each : runs) ASSERT_EQ(each.load(), round + 1);
    }
  }
}

}  // namespace
}  // namespace vsfind
