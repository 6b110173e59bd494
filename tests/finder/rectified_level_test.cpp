// A coarse level seen straight on shows at every pixel of its grid what the plane has there.
#include "finder/rectified_level.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <string>
#include <vector>

#include "app/render/random.h"
#include "calibrated_stage.h"

namespace vsfind {
namespace {

/// Grey value of a plane point: waves.
double grey_at(const Eigen::Vector2d& plane, double period) {
  return 128.0 + 50.0 * std::sin(6.283 * plane.x() / period) + 40.0 * std::cos(6.283 * plane.y() / period);
}

/// A level as if halved three times: of a frame of 640 x 480 or of its field.
struct MadeLevel {
  std::vector<std::uint8_t> memory;
  Level level;
};

MadeLevel level_of(const Mapping& mapping, double period, int padding = 0) {
  MadeLevel made;
  Level& level = made.level;
  level.width = 80;
  level.height = 60;
  level.stride = level.width + padding;
  level.step_x = 8.0;
  level.step_y = mapping.field() == Field::frame ? 8.0 : 4.0;
  level.offset_x = 3.5;
  level.offset_y = (level.step_y - 1.0) / 2.0;
  made.memory.assign(static_cast<std::size_t>(level.stride) * 60, 255);
  for (int v = 0; v < level.height; ++v) {
    for (int u = 0; u < level.width; ++u) {
      const Eigen::Vector2d plane = mapping.plane_from_image(level.image_from_level({u, v}));
      const double grey = plane.allFinite() ? grey_at(plane, period) : 0.0;
      made.memory[static_cast<std::size_t>(v * level.stride + u)] = static_cast<std::uint8_t>(std::lround(grey));
    }
  }
  level.data = made.memory.data();
  return made;
}

/// The largest error over the pixels of the grid whose surroundings the picture shows; how many those are in `seen`.
double largest_error(const RectifiedLevel& rectified, const Level& level, const Mapping& mapping, double period,
                     int& seen) {
  double largest = 0.0;
  seen = 0;
  const Level& grid = rectified.level();
  for (int v = 0; v < grid.height; ++v) {
    for (int u = 0; u < grid.width; ++u) {
      const Eigen::Vector2d plane = rectified.mapping().plane_from_image({u, v});
      const Eigen::Vector2d p = level.level_from_image(mapping.image_from_plane(plane));
      if (!(p.x() >= 2.0 && p.y() >= 2.0 && p.x() <= level.width - 3.0 && p.y() <= level.height - 3.0)) continue;
      ++seen;
      largest = std::max(largest, std::abs(grid.row(v)[u] - grey_at(plane, period)));
    }
  }
  return largest;
}

constexpr double far_reach = 1e6;  // plane units: of a pattern for which it always pays

TEST(RectifiedLevel, ShowsThePlane) {
  for (const measure::Camera& camera :
       {measure::slanted_camera(), measure::slanted_lens_camera(), measure::steep_camera()}) {
    for (const Field field : {Field::frame, Field::top, Field::bottom}) {
      SCOPED_TRACE(camera.name + ", " + name(field));
      const Mapping mapping = camera.mapping.for_field(field);
      // Waves of 40 level pixels in the middle, of 20 where the steep camera sees them smallest.
      const double period = camera.unit * 8.0 * 40.0;
      const MadeLevel made = level_of(mapping, period, 5);
      RectifiedLevel rectified;
      ASSERT_TRUE(rectified.update(made.level, mapping, far_reach));
      int seen = 0;
      EXPECT_LT(largest_error(rectified, made.level, mapping, period, seen), 3.0);
      EXPECT_GT(seen, 80 * 60 / 2);
      // In the middle its pixels are those of the level, or evenly larger, so that there are no more of them.
      const Eigen::Vector2d plane = mapping.plane_from_image(made.level.image_from_level({39.5, 29.5}));
      Eigen::Matrix2d slope = mapping.image_from_plane_jacobian(plane);
      slope.row(0) /= made.level.step_x;
      slope.row(1) /= made.level.step_y;
      const Eigen::Matrix2d grid_slope = rectified.mapping().image_from_plane_jacobian(plane);
      const double shrunk = grid_slope.norm() / slope.norm();
      EXPECT_LT((grid_slope - shrunk * slope).norm(), 1e-9 * slope.norm());
      EXPECT_GE(shrunk, 0.6);
      EXPECT_LE(shrunk, 1.0 + 1e-9);
      const double pixels = 1.0 * rectified.level().width * rectified.level().height;
      // The steep camera's grid is bounded by reading the level once for each pixel.
      if (camera.name != measure::steep_camera().name) {
        EXPECT_LT(pixels, 1.15 * 80 * 60);
      }
    }
  }
}

TEST(RectifiedLevel, IsLeftOutWhereItDoesNotPay) {
  RectifiedLevel rectified;
  const MadeLevel flat = level_of(Mapping::from_pixel_aspect(59.0 / 54.0), 200.0);
  EXPECT_FALSE(rectified.update(flat.level, Mapping::from_pixel_aspect(59.0 / 54.0), far_reach));
  const measure::Camera camera = measure::slanted_camera();
  const MadeLevel made = level_of(camera.mapping, 100.0);
  // Half a level pixel is 2 mm here: a change of the slope by 40% moves points 10 mm from the middle by as much.
  EXPECT_FALSE(rectified.update(made.level, camera.mapping, 4.0));
  EXPECT_TRUE(rectified.update(made.level, camera.mapping, 20.0));
  // The plane edge-on in the middle of the picture: no slope to go by.
  Eigen::Matrix3d beyond;
  beyond << 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0 / 100.0, 0.0, 1.0;
  EXPECT_FALSE(rectified.update(made.level, Mapping::from_homography(beyond).for_field(Field::frame), 0.0));
  const Level thin{made.level.data, 1, 60, 80};
  EXPECT_FALSE(rectified.update(thin, camera.mapping, far_reach));
}

TEST(RectifiedLevel, WhatThePictureDoesNotShowIsItsMean) {
  const measure::Camera camera = measure::slanted_camera();
  const MadeLevel made = level_of(camera.mapping, 100.0);
  RectifiedLevel rectified;
  ASSERT_TRUE(rectified.update(made.level, camera.mapping, far_reach));
  double mean = 0.0;
  for (const std::uint8_t grey : made.memory) mean += grey / static_cast<double>(made.memory.size());
  int unseen = 0;
  const Level& grid = rectified.level();
  for (int v = 0; v < grid.height; ++v) {
    for (int u = 0; u < grid.width; ++u) {
      const Eigen::Vector2d p =
          made.level.level_from_image(camera.mapping.image_from_plane(rectified.mapping().plane_from_image({u, v})));
      if (p.x() > -0.6 && p.y() > -0.6 && p.x() < 79.6 && p.y() < 59.6) continue;
      ++unseen;
      EXPECT_NEAR(grid.row(v)[u], mean, 0.6) << u << " " << v;
    }
  }
  EXPECT_GT(unseen, 100);
}

TEST(RectifiedLevel, TellsOfEachRowWhatThePictureShows) {
  const measure::Camera camera = measure::slanted_camera();
  const MadeLevel made = level_of(camera.mapping, 100.0);
  RectifiedLevel rectified;
  ASSERT_TRUE(rectified.update(made.level, camera.mapping, far_reach));
  const Level& grid = rectified.level();
  ASSERT_EQ(rectified.shown().size(), static_cast<std::size_t>(grid.height));
  int outside = 0;
  for (int v = 0; v < grid.height; ++v) {
    const ColumnRange& shown = rectified.shown()[static_cast<std::size_t>(v)];
    for (int u = 0; u < grid.width; ++u) {
      const Eigen::Vector2d p =
          made.level.level_from_image(camera.mapping.image_from_plane(rectified.mapping().plane_from_image({u, v})));
      const bool in = p.x() > -0.4 && p.y() > -0.4 && p.x() < 79.4 && p.y() < 59.4;
      const bool out = p.x() < -0.6 || p.y() < -0.6 || p.x() > 79.6 || p.y() > 59.6;
      const bool told = u >= shown.left && u <= shown.right;
      EXPECT_FALSE((in && !told) || (out && told)) << u << " " << v;
      outside += told ? 0 : 1;
    }
  }
  EXPECT_GT(outside, 100);
}

TEST(RectifiedLevel, ServesBothFieldsInTurn) {
  const measure::Camera camera = measure::slanted_lens_camera();
  const double period = camera.unit * 8.0 * 25.0;
  RectifiedLevel rectified;
  std::vector<std::vector<std::uint8_t>> first;
  for (int turn = 0; turn < 3; ++turn) {
    for (const Field field : {Field::top, Field::bottom}) {
      const Mapping mapping = camera.mapping.for_field(field);
      const MadeLevel made = level_of(mapping, period);
      ASSERT_TRUE(rectified.update(made.level, mapping, far_reach));
      const Level& grid = rectified.level();
      const std::vector<std::uint8_t> pixels(grid.data, grid.data + grid.width * grid.height);
      if (turn == 0) {
        first.push_back(pixels);
      } else {
        EXPECT_EQ(pixels, first[field == Field::top ? 0 : 1]);
      }
    }
  }
  EXPECT_NE(first[0], first[1]);
}

// The horizon runs through the picture: the plane goes on without end, the grid does not.
TEST(RectifiedLevel, StaysSmallBeforeTheHorizon) {
  Eigen::Matrix3d frame_from_plane;
  frame_from_plane << 1.0, 0.6, 320.0, 0.0, 0.3, 240.0, 0.0, 2e-3, 1.0;
  const Mapping mapping = Mapping::from_homography(frame_from_plane);
  const MadeLevel made = level_of(mapping, 300.0);
  RectifiedLevel rectified;
  ASSERT_TRUE(rectified.update(made.level, mapping, far_reach));
  EXPECT_LE(rectified.level().width * rectified.level().height, 3 * 80 * 60 + 500);
}

TEST(RectifiedLevel, ARegionCoversItsPoints) {
  const measure::Camera camera = measure::slanted_lens_camera();
  const Mapping mapping = camera.mapping.for_field(Field::bottom);
  const MadeLevel made = level_of(mapping, 100.0);
  RectifiedLevel rectified;
  ASSERT_TRUE(rectified.update(made.level, mapping, far_reach));
  render::Random random(4);
  for (const Roi& frame : {Roi{0, 0, 640, 480}, Roi{500, 20, 60, 90}, Roi{10, 400, 1, 1}}) {
    const auto region = rectified.region(frame);
    ASSERT_TRUE(region.has_value());
    for (int i = 0; i < 200; ++i) {
      const Eigen::Vector2d at(frame.x - 0.5 + frame.width * random.uniform(),
                               frame.y - 0.5 + frame.height * random.uniform());
      const Eigen::Vector2d p =
          rectified.mapping().image_from_plane(mapping.plane_from_image(mapping.image_from_frame(at)));
      EXPECT_TRUE(p.x() >= region->x && p.y() >= region->y && p.x() <= region->x + region->width - 1 &&
                  p.y() <= region->y + region->height - 1)
          << at.transpose();
    }
    EXPECT_LT(region->width * region->height, 4 * (frame.width / 8 + 5) * (frame.height / 8 + 5));
  }
}

}  // namespace
}  // namespace vsfind
