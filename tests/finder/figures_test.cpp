/// The paper's two figures: where training puts its points.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "app/render/patterns.h"
#include "app/render/sensor.h"
#include "finder/search.h"
#include "finder/train.h"

namespace vsfind {
namespace {

using render::Picture;

constexpr double square_size = 191.0;
constexpr double ring_width = 20.0;

Picture picture_of(const std::vector<render::Item>& items, std::uint64_t seed, int width = 320, int height = 320) {
  render::Scene scene;
  scene.width = width;
  scene.height = height;
  scene.items = items;
  render::Sensor sensor;
  sensor.seed = seed;
  return render::develop(render::expose(scene, 0.7), sensor);
}

/// Concentric squares, a little off the pixel grid, with some background around them.
Pattern trained_squares(const Range& angle) {
  TrainOptions options;
  options.roi = {59, 59, 203, 203};
  options.angle_deg = angle;
  const Picture picture = picture_of({{render::bullseye(square_size, ring_width), {160.3, 159.8, 0.0, 1.0, 1.0}}}, 3);
  return train(picture.view(), Mapping(), options);
}

/// Full-resolution points of the pose on the sides of the squares.
struct OnSides {
  std::size_t all = 0;
  std::size_t on_a_side = 0;
  std::size_t in_outer_part = 0;                  ///< the outer 30% of a side, half of it at each corner
  std::vector<std::array<std::size_t, 4>> sides;  ///< by square from outside, then right, bottom, left, top
  std::vector<std::array<std::size_t, 5>> along;  ///< by square, fifths of its sides from one corner to the other
  [[nodiscard]] std::size_t of_square(std::size_t index) const {
    std::size_t sum = 0;
    for (const std::size_t side : sides[index]) sum += side;
    return sum;
  }
};

constexpr double middle_x = 0.3;  // of the squares, from the pattern's origin
constexpr double middle_y = -0.2;

std::vector<double> half_sides() {
  std::vector<double> halves;
  for (double side = square_size; side > 0.25 * ring_width; side -= 2.0 * ring_width) halves.push_back(side / 2.0);
  return halves;
}

OnSides on_sides(const Pattern& pattern) {
  const std::vector<double> halves = half_sides();
  OnSides result;
  result.sides.resize(halves.size());
  result.along.resize(halves.size());
  for (const PointSet& set : pattern.sets) {
    if (set.level != 0 || (set.use != PointUse::refine && set.use != PointUse::outline)) continue;
    for (const PatternPoint& point : set.points) {
      ++result.all;
      const double x = point.x - middle_x;
      const double y = point.y - middle_y;
      const double distance = std::max(std::abs(x), std::abs(y));
      for (std::size_t k = 0; k < halves.size(); ++k) {
        constexpr double reach = 5.0;  // of an edge as training reads it
        if (std::abs(distance - halves[k]) > reach) continue;
        const bool upright = std::abs(x) > std::abs(y);
        const double part = std::clamp((upright ? y : x) / halves[k], -1.0, 1.0);
        const std::size_t side = upright ? (x > 0.0 ? 0 : 2) : (y > 0.0 ? 1 : 3);
        ++result.on_a_side;
        ++result.sides[k][side];
        ++result.along[k][static_cast<std::size_t>(std::min(4.0, (part + 1.0) * 2.5))];
        if (std::abs(part) > 0.7) ++result.in_outer_part;
      }
    }
  }
  return result;
}

TEST(FigureOne, WithRotationThePointsOfThePoseLieAtTheCorners) {
  const OnSides found = on_sides(trained_squares({-45.0, 45.0}));
  ASSERT_GT(found.all, 300U);
  EXPECT_GE(2 * found.in_outer_part, found.all);
  // The two outer squares have 62% of all edges.
  EXPECT_GE(static_cast<double>(found.of_square(0) + found.of_square(1)), 0.85 * static_cast<double>(found.on_a_side));
}

TEST(FigureOne, WithoutRotationThePointsOfThePoseAreSpreadAlongAllEdges) {
  const OnSides found = on_sides(trained_squares({0.0, 0.0}));
  ASSERT_GT(found.all, 300U);
  const std::vector<double> halves = half_sides();
  double length = 0.0;  // of a side of each square
  for (const double half : halves) length += 2.0 * half;
  for (std::size_t k = 0; k < halves.size(); ++k) {
    const double square_share = static_cast<double>(found.on_a_side) * 2.0 * halves[k] / length;
    // Each square has its share to a quarter, each of its sides and each fifth of the way from corner to corner within
    // a factor of 2, where chance leaves enough points to tell.
    EXPECT_NEAR(static_cast<double>(found.of_square(k)), square_share, 0.25 * square_share) << "square " << k;
    constexpr double enough = 10.0;
    for (const std::size_t side : found.sides[k]) {
      if (square_share / 4.0 < enough) continue;
      EXPECT_GT(static_cast<double>(side), square_share / 4.0 / 2.0) << "square " << k;
      EXPECT_LT(static_cast<double>(side), square_share / 4.0 * 2.0) << "square " << k;
    }
    for (const std::size_t fifth : found.along[k]) {
      if (square_share / 5.0 < enough) continue;
      EXPECT_GT(static_cast<double>(fifth), square_share / 5.0 / 2.0) << "square " << k;
      EXPECT_LT(static_cast<double>(fifth), square_share / 5.0 * 2.0) << "square " << k;
    }
  }
}

constexpr double outer = 100.0;  // diameters of the ring; the disc's is the outer one
constexpr double inner = 50.0;

render::Item ring_at(double x, double y) { return {render::ring(outer, inner), {x, y, 0.0, 1.0, 1.0}}; }
render::Item disc_at(double x, double y) { return {render::disc(outer), {x, y, 0.0, 1.0, 1.0}}; }

/// A ring trained against a disc.
Pattern trained_ring(const Range& angle, bool against) {
  TrainOptions options;
  options.roi = {100, 100, 120, 120};
  options.angle_deg = angle;
  const Picture disc = picture_of({disc_at(150.3, 170.2)}, 4);
  if (against) options.against = {disc.view()};
  return train(picture_of({ring_at(159.8, 159.6)}, 3).view(), Mapping(), options);
}

/// Points of the exhaustive search: all, and those in the hole.
std::pair<std::size_t, std::size_t> search_points_in_hole(const Pattern& pattern) {
  std::size_t all = 0;
  std::size_t in_hole = 0;
  for (const PointSet& set : pattern.sets) {
    if (set.use != PointUse::search) continue;
    all += set.points.size();
    in_hole += static_cast<std::size_t>(std::count_if(set.points.begin(), set.points.end(), [](const PatternPoint& p) {
      return std::hypot(p.x - 0.3, p.y - 0.1) < inner / 2.0;
    }));
  }
  return {all, in_hole};
}

TEST(FigureTwo, ARingTrainedAgainstADiscHasItsSearchPointsInTheHole) {
  for (const double angle : {0.0, 45.0}) {
    const auto [all, in_hole] = search_points_in_hole(trained_ring({-angle, angle}, true));
    const auto [all_alone, in_hole_alone] = search_points_in_hole(trained_ring({-angle, angle}, false));
    EXPECT_GE(2 * in_hole, all) << "angle " << angle;
    // It is the disc that makes the difference: the hole is 14% of the pattern's area.
    EXPECT_LT(2 * in_hole_alone, all_alone) << "angle " << angle;
  }
}

TEST(FigureTwo, TheDiscIsNeverTakenForTheRing) {
  SearchOptions all;
  all.max_instances = 0;
  Finder finder({std::make_shared<const Pattern>(trained_ring({0.0, 0.0}, true))}, all);
  for (std::uint64_t seed = 100; seed < 120; ++seed) {
    const auto shift = static_cast<double>(seed - 100);
    const Picture discs = picture_of(
        {disc_at(70.0 + 1.37 * shift, 75.0 + 0.9 * shift), disc_at(230.0 - 0.8 * shift, 240.0 - 1.1 * shift)}, seed);
    EXPECT_TRUE(finder.find(discs.view(), Mapping())[0].matches.empty()) << seed;
    const double x = 230.0 - 1.3 * shift;
    const double y = 80.0 + 0.6 * shift;
    const Picture both = picture_of({disc_at(75.0 + 0.7 * shift, 240.0 - 0.9 * shift), ring_at(x, y)}, seed + 1000);
    const auto& matches = finder.find(both.view(), Mapping())[0].matches;
    ASSERT_EQ(matches.size(), 1U) << seed;
    // The origin is the centre of the ROI, (159.5, 159.5); the ring was trained at (159.8, 159.6).
    EXPECT_NEAR(matches[0].pose.x, x - 0.3, 0.05);
    EXPECT_NEAR(matches[0].pose.y, y - 0.1, 0.05);
  }
}

}  // namespace
}  // namespace vsfind
