// Patterns trained through one view of the plane are found anywhere on it, in their true shape.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "app/render/patterns.h"
#include "calibrated_stage.h"

namespace vsfind::measure {
namespace {

struct Expected {
  double most_px;
  double mean_px;
  double angle_deg;
};

/// Searches `scenes` of them, all of which must be right.
void expect_found(const Camera& camera, const render::Drawing& drawing, double angle_limit, Field field, int scenes,
                  const Expected& expected) {
  SCOPED_TRACE(camera.name + ", " + name(field));
  const CalibratedPattern trained = train_through(camera, drawing, {330.0, 250.0}, {-angle_limit, angle_limit}, 1);
  EXPECT_EQ(trained.pattern->unit, camera.plane_unit);
  Finder finder({trained.pattern}, {});
  CalibratedRecipe recipe;
  recipe.angle_limit = angle_limit;
  recipe.field = field;
  double sum = 0.0;
  for (int i = 0; i < scenes; ++i) {
    const CalibratedShot shot = shot_through(camera, trained, recipe, static_cast<std::uint64_t>(i) + 1);
    const auto& matches = finder.find(shot.picture.view(), shot.mapping)[0].matches;
    ASSERT_EQ(matches.size(), 1U) << "scene " << i;
    const CalibratedError error = error_of(matches[0], shot, *trained.pattern);
    EXPECT_LT(std::hypot(error.x, error.y), expected.most_px) << "scene " << i;
    EXPECT_LT(std::abs(error.angle_deg), expected.angle_deg) << "scene " << i;
    const Eigen::Vector2d frame = camera.mapping.image_from_plane({matches[0].pose.x, matches[0].pose.y});
    EXPECT_LT((frame - matches[0].frame_position).norm(), 1e-6);
    sum += std::hypot(error.x, error.y);
  }
  EXPECT_LT(sum / scenes, expected.mean_px);
}

render::Drawing part() { return render::artwork(3, 150.0, 130.0); }

TEST(Calibrated, PixelAspectAtAnyAngle) {
  expect_found(pixel_aspect_camera(), part(), 180.0, Field::frame, 6, {0.01, 0.01, 0.01});
}

TEST(Calibrated, SlantedPlane) { expect_found(slanted_camera(), part(), 60.0, Field::frame, 6, {0.03, 0.01, 0.02}); }

TEST(Calibrated, SlantedPlaneThroughALens) {
  expect_found(slanted_lens_camera(), part(), 60.0, Field::frame, 6, {0.06, 0.02, 0.04});
}

TEST(Calibrated, Fields) {
  for (const Camera& camera : {pixel_aspect_camera(), slanted_camera(), slanted_lens_camera()}) {
    for (const Field field : {Field::top, Field::bottom}) {
      expect_found(camera, part(), 60.0, field, 3, {0.03, 0.015, 0.03});
    }
  }
}

// A small pattern under perspective that changes its size twofold.
TEST(Calibrated, SmallPatternsUnderStrongPerspective) {
  expect_found(steep_camera(), render::artwork(5, 100.0, 86.0), 60.0, Field::frame, 12, {0.3, 0.05, 0.3});
}

TEST(Calibrated, TheRegionLimitsTheOriginThroughPerspective) {
  const Camera camera = steep_camera();
  const CalibratedPattern trained =
      train_through(camera, render::artwork(5, 100.0, 86.0), {330.0, 250.0}, {-20.0, 20.0}, 1);
  CalibratedRecipe recipe;
  recipe.angle_limit = 20.0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const CalibratedShot shot = shot_through(camera, trained, recipe, seed);
    const Eigen::Vector2d at = camera.mapping.image_from_plane({shot.truth.x, shot.truth.y});
    SearchOptions options;
    options.region = Roi{static_cast<int>(at.x()) - 5, static_cast<int>(at.y()) - 5, 12, 12};
    Finder near({trained.pattern}, options);
    EXPECT_EQ(near.find(shot.picture.view(), shot.mapping)[0].matches.size(), 1U);
    options.region->x += at.x() < 320.0 ? 30 : -30;
    Finder beside({trained.pattern}, options);
    EXPECT_TRUE(beside.find(shot.picture.view(), shot.mapping)[0].matches.empty());
  }
}

// What one camera has learnt, another one finds.
TEST(Calibrated, TrainedThroughOneCameraFoundThroughAnother) {
  const Camera first = slanted_camera();
  const CalibratedPattern trained = train_through(first, part(), {300.0, 260.0}, {-60.0, 60.0}, 2);
  for (const Camera& second : {straight_camera(), slanted_lens_camera()}) {
    SCOPED_TRACE(second.name);
    Finder finder({trained.pattern}, {});
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      const CalibratedShot shot = shot_through(second, trained, {}, seed);
      const auto& matches = finder.find(shot.picture.view(), shot.mapping)[0].matches;
      ASSERT_EQ(matches.size(), 1U);
      const CalibratedError error = error_of(matches[0], shot, *trained.pattern);
      EXPECT_LT(std::hypot(error.x, error.y), 0.06);
      EXPECT_LT(std::abs(error.angle_deg), 0.04);
    }
  }
}

}  // namespace
}  // namespace vsfind::measure
