/// Truth, occlusion and clutter are what they say.
#include "app/render/truth.h"

#include <gtest/gtest.h>

#include <cmath>

#include "app/render/clutter.h"
#include "app/render/patterns.h"

namespace vsfind::render {
namespace {

/// A point of the drawing goes to the same place directly and by way of the trained pattern.
TEST(Truth, ExpectedPoseTakesTrainedPointsToTheScene) {
  const Pose train{320.3, 240.8, 0.0, 1.02, 0.97};
  const Eigen::Vector2d origin(319.0, 242.5);
  for (const Pose& scene : {Pose{100.0, 90.0, 33.0, 1.1, 0.9}, Pose{400.0, 111.0, -170.0, 0.8, 1.3}}) {
    const Pose pose = expected_pose(train, scene, origin);
    for (const Eigen::Vector2d& point : {Eigen::Vector2d(0, 0), Eigen::Vector2d(50, -20), Eigen::Vector2d(-3, 44)}) {
      const Eigen::Vector2d trained = plane_from_pattern(train, point);
      const Eigen::Vector2d direct = plane_from_pattern(scene, point);
      EXPECT_LT((plane_from_pattern(pose, trained - origin) - direct).norm(), 1e-9);
    }
  }
  const Pose turned_pose = expected_pose({10, 20, 30, 1, 1}, {110, 120, 50, 1, 1}, {10, 20});
  EXPECT_NEAR(turned_pose.angle_deg, 20.0, 1e-9);
  EXPECT_NEAR(turned_pose.x, 110.0, 1e-9);
}

TEST(Truth, AngleDifferenceGoesTheShortWay) {
  EXPECT_NEAR(angle_difference_deg(179.0, -179.0), -2.0, 1e-12);
  EXPECT_NEAR(angle_difference_deg(10.0, 4.0), 6.0, 1e-12);
}

TEST(Truth, OccludersHideThePartAskedFor) {
  Random random(7);
  for (const double part : {0.2, 0.35}) {
    for (int i = 0; i < 12; ++i) {
      const Drawing pattern = artwork(3);
      EXPECT_NEAR(hidden_part(pattern, occluders(random, pattern, part)), part, 0.05) << i;
    }
  }
}

/// Rendered: the part of the box whose pixels the occluder changes.
TEST(Truth, HiddenPartIsWhatIsSeen) {
  const Drawing square{{{{rectangle(-50, -50, 50, 50)}, 100.0}}, 100.0, 100.0};
  const Drawing cover{{{{rectangle(-60, -60, 0, 0)}, 0.0}, {{circle({30, 30}, 10.0)}, 0.0}}, 1.0, 1.0};
  EXPECT_NEAR(hidden_part(square, cover), 0.25 + 3.14159 * 100.0 / 10000.0, 0.005);
}

TEST(Truth, PlacesKeepThePartInsideThatWasAskedFor) {
  Random random(11);
  Scene scene;
  for (const double outside : {0.0, 0.33}) {
    for (int i = 0; i < 20; ++i) {
      Item item{bullseye(), {0, 0, random.uniform(-45, 45), 1, 1}};
      const auto pose = random_place(random, scene, item, outside);
      ASSERT_TRUE(pose.has_value());
      item.pose = *pose;
      EXPECT_NEAR(outside_part(scene, item), outside, 0.01);
    }
  }
}

/// Every seed gives a drawing, also where its parts find no room of their own.
TEST(Truth, ArtworkOfEverySeedEnds) {
  for (std::uint64_t seed = 0; seed < 2000; ++seed) EXPECT_EQ(artwork(seed, 60.0, 40.0).shapes.size(), 10U);
}

TEST(Truth, RemappedRegionsStayApart) {
  Random random(5);
  for (int i = 0; i < 20; ++i) {
    const Drawing drawing = bullseye();
    const Drawing other = remapped(random, drawing, 200.0, 3);
    ASSERT_EQ(other.shapes.size(), drawing.shapes.size() + 3);
    double below = 200.0;
    for (std::size_t k = 0; k < drawing.shapes.size(); ++k) {
      EXPECT_GE(std::abs(other.shapes[k].grey - below), 35.0);
      below = other.shapes[k].grey;
    }
  }
}

}  // namespace
}  // namespace vsfind::render
