/// What must hold of any search, by its public headers alone.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "app/render/patterns.h"
#include "app/render/random.h"
#include "app/render/sensor.h"
#include "app/render/truth.h"
#include "finder/search.h"
#include "finder/train.h"

namespace vsfind {
namespace {

/// Artwork without symmetry at a pose, in a picture of any size.
render::Exposure exposure_at(const Pose& pose, int width = 320, int height = 240) {
  render::Scene scene;
  scene.width = width;
  scene.height = height;
  scene.items.push_back({render::artwork(5, 100.0, 86.0), pose});
  return render::expose(scene, 0.7);
}

render::Picture picture_at(const Pose& pose, double noise = 2.0, double gain = 1.0, double offset = 0.0, int bits = 8) {
  render::Sensor sensor;
  sensor.noise = noise;
  sensor.gain = gain;
  sensor.offset = offset;
  sensor.bits = bits;
  return render::develop(exposure_at(pose), sensor);
}

const std::shared_ptr<const Pattern>& pattern() {
  static const std::shared_ptr<const Pattern> trained = [] {
    TrainOptions options;
    options.roi = {110, 77, 100, 86};
    options.angle_deg = {-20.0, 20.0};
    return std::make_shared<const Pattern>(train(picture_at({159.5, 119.5, 0.0, 1.0, 1.0}).view(), Mapping(), options));
  }();
  return trained;
}

std::vector<Match> found_in(const ImageView& image, const SearchOptions& options = {}) {
  Finder finder({pattern()}, options);
  return finder.find(image, Mapping()).front().matches;
}

Match only_match(const ImageView& image) {
  const auto matches = found_in(image);
  EXPECT_EQ(matches.size(), 1U);
  if (!matches.empty()) return matches.front();
  Match none;
  none.frame_position.setZero();
  return none;
}

bool is_finite(const Match& m) {
  for (const double v : {m.pose.x, m.pose.y, m.pose.angle_deg, m.pose.scale_x, m.pose.scale_y, m.score, m.sigma_x,
                         m.sigma_y, m.sigma_angle_deg, m.visible, m.frame_position.x(), m.frame_position.y()}) {
    if (!std::isfinite(v)) return false;
  }
  return true;
}

TEST(FinderProperty, AnyPictureIsSearchedWithoutExceptionOrNaN) {
  SearchOptions eager;
  eager.min_score = 0.0;
  eager.max_instances = 0;
  Finder finder({pattern()}, eager);
  struct Size {
    int width, height;
  };
  for (const int bits : {8, 12, 16}) {
    const auto white = static_cast<int>((1U << static_cast<unsigned>(bits)) - 1U);
    for (const auto& [width, height] :
         {Size{1, 1}, Size{1, 300}, Size{300, 1}, Size{2, 2}, Size{7, 9}, Size{64, 48}, Size{200, 150}}) {
      for (const int kind : {0, 1, 2, 3}) {
        render::Picture picture(width, height, bits);
        render::Random random(static_cast<std::uint64_t>(width * 7 + height + kind));
        for (int y = 0; y < height; ++y) {
          for (int x = 0; x < width; ++x) {
            // Black; white; pixels of either extreme at random; either extreme in turn.
            const int value = kind == 0   ? 0
                              : kind == 1 ? white
                              : kind == 2 ? random.integer(0, 1) * white
                                          : (x + y) % 2 * white;
            picture.set(x, y, value);
          }
        }
        SCOPED_TRACE(testing::Message() << width << "x" << height << ", " << bits << " bits, kind " << kind);
        std::vector<Match> matches;
        ASSERT_NO_THROW(matches = finder.find(picture.view(), Mapping()).front().matches);
        for (const Match& match : matches) EXPECT_TRUE(is_finite(match));
        if (kind < 2) {
          SearchOptions usual;
          EXPECT_TRUE(found_in(picture.view(), usual).empty());  // a plain picture holds no pattern
        }
      }
    }
  }
  EXPECT_TRUE(finder.find({}, Mapping()).front().matches.empty());
}

TEST(FinderProperty, GainAndOffsetChangeNothing) {
  // 16 bits, so that rounding does not differ between the two.
  const Pose pose{163.3, 118.6, 7.0, 1.0, 1.0};
  const Match plain = only_match(picture_at(pose, 0.0, 1.0, 0.0, 16).view());
  for (const auto& [gain, offset] : {std::pair{0.5, 0.0}, {0.5, 90.0}, {1.1, 0.0}, {0.25, 20.0}}) {
    const Match changed = only_match(picture_at(pose, 0.0, gain, offset, 16).view());
    EXPECT_NEAR(changed.pose.x, plain.pose.x, 0.003) << gain << " " << offset;
    EXPECT_NEAR(changed.pose.y, plain.pose.y, 0.003) << gain << " " << offset;
    EXPECT_NEAR(changed.pose.angle_deg, plain.pose.angle_deg, 0.005) << gain << " " << offset;
    EXPECT_NEAR(changed.score, plain.score, 0.005) << gain << " " << offset;
  }
}

TEST(FinderProperty, TheSameInsideALargerPicture) {
  const render::Picture small = picture_at({150.2, 121.7, -11.0, 1.0, 1.0});
  const Match alone = only_match(small.view());
  constexpr int step = 64;  // whole pixels of every level, so that the pyramid's pixels are the same ones
  render::Picture large(small.width() + 3 * step, small.height() + 2 * step, 8);
  for (int y = 0; y < large.height(); ++y) {
    for (int x = 0; x < large.width(); ++x) {
      const int u = x - 2 * step;
      const int v = y - step;
      const bool inside = u >= 0 && v >= 0 && u < small.width() && v < small.height();
      large.set(x, y, inside ? small.view().at(u, v) : 200);
    }
  }
  const Match embedded = only_match(large.view());
  EXPECT_NEAR(embedded.pose.x - 2 * step, alone.pose.x, 1e-4);
  EXPECT_NEAR(embedded.pose.y - step, alone.pose.y, 1e-4);
  EXPECT_NEAR(embedded.pose.angle_deg, alone.pose.angle_deg, 1e-4);
  EXPECT_NEAR(embedded.score, alone.score, 1e-6);
}

/// One of the eight ways to turn and mirror a picture: mirrored from left to right first, if at all, then turned by
/// quarters from +x toward +y. Transposition is both: mirrored, and three quarters.
struct Turned {
  bool mirrored = false;
  int quarters = 0;
  int width = 0;  ///< of the picture before
  int height = 0;

  /// Where a place of the picture goes.
  [[nodiscard]] Eigen::Vector2d place(double x, double y) const {
    if (mirrored) x = width - 1 - x;
    int w = width;
    int h = height;
    for (int i = 0; i < quarters; ++i) {
      const double from_top = y;
      y = x;
      x = h - 1 - from_top;
      std::swap(w, h);
    }
    return {x, y};
  }
  [[nodiscard]] render::Picture picture(const ImageView& view) const {
    const bool lies = quarters % 2 != 0;
    render::Picture made(lies ? height : width, lies ? width : height, view.bits);
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        const Eigen::Vector2d to = place(u, v);
        made.set(static_cast<int>(to.x()), static_cast<int>(to.y()), view.at(u, v));
      }
    }
    return made;
  }
};

TEST(FinderProperty, TurnedAndMirroredPicturesGiveTurnedAndMirroredPoses) {
  const Roi roi{110, 77, 100, 86};
  const Eigen::Vector2d origin = render::roi_centre(roi);
  const Pose trained{159.5, 119.5, 0.0, 1.0, 1.0};
  const Pose pose{166.3, 117.6, 7.0, 1.0, 1.0};
  const Pose truth = render::expected_pose(trained, pose, origin);
  const render::Picture teaching = picture_at(trained, 0.0, 1.0, 0.0, 16);
  const render::Picture scene = picture_at(pose, 0.0, 1.0, 0.0, 16);
  for (const bool mirrored : {false, true}) {
    for (const int quarters : {0, 1, 2, 3}) {
      SCOPED_TRACE(testing::Message() << (mirrored ? "mirrored, " : "") << quarters << " quarters");
      const Turned way{mirrored, quarters, 320, 240};
      const Eigen::Vector2d a = way.place(roi.x, roi.y);
      const Eigen::Vector2d b = way.place(roi.x + roi.width - 1, roi.y + roi.height - 1);
      TrainOptions options;
      options.roi = {static_cast<int>(std::min(a.x(), b.x())), static_cast<int>(std::min(a.y(), b.y())),
                     static_cast<int>(std::abs(a.x() - b.x())) + 1, static_cast<int>(std::abs(a.y() - b.y())) + 1};
      options.angle_deg = {-20.0, 20.0};
      const auto turned =
          std::make_shared<const Pattern>(train(way.picture(teaching.view()).view(), Mapping(), options));
      Finder finder({turned}, {});
      const auto& matches = finder.find(way.picture(scene.view()).view(), Mapping()).front().matches;
      ASSERT_EQ(matches.size(), 1U);
      const Eigen::Vector2d place = way.place(truth.x, truth.y);
      EXPECT_NEAR(matches[0].pose.x, place.x(), 0.005);
      EXPECT_NEAR(matches[0].pose.y, place.y(), 0.005);
      EXPECT_NEAR(matches[0].pose.angle_deg, mirrored ? -truth.angle_deg : truth.angle_deg, 0.005);
      EXPECT_GT(matches[0].score, 0.99);
    }
  }
}

// No hole between the steps of the coarse search. (`pose_grid` tries as many poses as one likes.)
TEST(FinderProperty, EveryPoseIsFound) {
  TrainOptions options;
  options.roi = {85, 67, 70, 66};
  options.angle_deg = {-180.0, 180.0};
  const auto picture = [](const Pose& pose, std::uint64_t seed) {
    render::Scene scene;
    scene.width = 240;
    scene.height = 200;
    scene.items.push_back({render::artwork(5, 70.0, 66.0), pose});
    render::Sensor sensor;
    sensor.seed = seed;
    return render::develop(render::expose(scene, 0.7, Field::frame, 4), sensor);
  };
  const Pose trained{119.5, 99.5, 0.0, 1.0, 1.0};
  const auto any_angle = std::make_shared<const Pattern>(train(picture(trained, 1).view(), Mapping(), options));
  Finder finder({any_angle}, {});
  render::Random random(11);
  for (int i = 0; i < 300; ++i) {
    const Pose pose{random.uniform(100.0, 140.0), random.uniform(80.0, 120.0), random.uniform(-180.0, 180.0), 1.0, 1.0};
    const Pose truth = render::expected_pose(trained, pose, render::roi_centre(options.roi));
    const auto& matches = finder.find(picture(pose, random.bits()).view(), Mapping()).front().matches;
    ASSERT_EQ(matches.size(), 1U) << pose.x << " " << pose.y << " " << pose.angle_deg;
    EXPECT_NEAR(matches[0].pose.x, truth.x, 0.1) << pose.angle_deg;
    EXPECT_NEAR(matches[0].pose.y, truth.y, 0.1) << pose.angle_deg;
    EXPECT_LT(std::abs(render::angle_difference_deg(matches[0].pose.angle_deg, truth.angle_deg)), 0.2);
  }
}

TEST(FinderProperty, SigmaGrowsWithTheNoise) {
  double last_x = 0.0;
  double last_angle = 0.0;
  for (const double noise : {1.0, 2.0, 4.0, 8.0, 16.0}) {
    // A mean of several: one picture's own estimate scatters.
    double sum_x = 0.0;
    double sum_angle = 0.0;
    for (const double shift : {0.0, 0.2, 0.4, 0.6, 0.8}) {
      const Match match = only_match(picture_at({159.2 + shift, 119.9 - shift, 3.0, 1.0, 1.0}, noise).view());
      sum_x += match.sigma_x / 5.0;
      sum_angle += match.sigma_angle_deg / 5.0;
    }
    EXPECT_GT(sum_x, last_x) << "noise " << noise;
    EXPECT_GT(sum_angle, last_angle) << "noise " << noise;
    last_x = sum_x;
    last_angle = sum_angle;
  }
}

}  // namespace
}  // namespace vsfind
