/// Training and search on rendered scenes of exactly known pose.
#include "finder/search.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "acquisition/errors.h"
#include "app/render/clutter.h"
#include "app/render/patterns.h"
#include "app/render/sensor.h"
#include "app/render/truth.h"
#include "finder/train.h"

namespace vsfind {
namespace {

using render::Picture;

/// The part lies off the pixel grid in training, as on a real camera.
constexpr Roi roi{85, 75, 150, 130};
const Pose train_pose{160.3, 140.6, 0.0, 1.0, 1.0};

Picture picture_of(const std::vector<Pose>& poses, std::uint64_t seed, int width = 320, int height = 280,
                   int bits = 8) {
  render::Scene scene;
  scene.width = width;
  scene.height = height;
  for (const Pose& pose : poses) scene.items.push_back({render::artwork(3), pose});
  render::Sensor sensor;
  sensor.seed = seed;
  sensor.bits = bits;
  return render::develop(render::expose(scene, 0.7), sensor);
}

TrainOptions options_for(double angle) {
  TrainOptions options;
  options.roi = roi;
  options.angle_deg = {-angle, angle};
  return options;
}

std::shared_ptr<const Pattern> trained(const TrainOptions& options) {
  const Picture picture = picture_of({train_pose}, 1);
  return std::make_shared<const Pattern>(train(picture.view(), Mapping(), options));
}

Pose truth(const Pose& scene) { return render::expected_pose(train_pose, scene, render::roi_centre(roi)); }

void expect_pose(const Match& match, const Pose& scene, double px, double deg) {
  const Pose want = truth(scene);
  EXPECT_NEAR(match.pose.x, want.x, px);
  EXPECT_NEAR(match.pose.y, want.y, px);
  EXPECT_NEAR(render::angle_difference_deg(match.pose.angle_deg, want.angle_deg), 0.0, deg);
}

TEST(Search, FindsPositionAndAngleToAHundredthOfAPixel) {
  Finder finder({trained(options_for(40.0))}, {});
  const Pose there{171.27, 133.81, 23.4, 1.0, 1.0};
  const auto& found = finder.find(picture_of({there}, 5).view(), Mapping());
  ASSERT_EQ(found.at(0).matches.size(), 1U);
  const Match& match = found[0].matches[0];
  expect_pose(match, there, 0.02, 0.02);
  EXPECT_GT(match.score, 0.98);
  EXPECT_GT(match.visible, 0.95);
  EXPECT_EQ(match.polarity, Polarity::same);
  EXPECT_GT(match.sigma_x, 0.0005);
  EXPECT_LT(match.sigma_x, 0.02);
  EXPECT_GT(finder.search_ms(), 0.0);
}

TEST(Search, TheStandardDeviationIsKnownWhereMuchDisagrees) {
  // So noisy that all points together have the say.
  Finder finder({trained(options_for(40.0))}, {});
  render::Scene scene;
  scene.width = 320;
  scene.height = 280;
  const Pose there{171.27, 133.81, 23.4, 1.0, 1.0};
  scene.items.push_back({render::artwork(3), there});
  render::Sensor sensor;
  sensor.noise = 40.0;
  sensor.seed = 5;
  const auto& matches = finder.find(render::develop(render::expose(scene, 0.7), sensor).view(), Mapping())[0].matches;
  ASSERT_EQ(matches.size(), 1U);
  for (const double sigma : {matches[0].sigma_x, matches[0].sigma_y, matches[0].sigma_angle_deg}) {
    EXPECT_GT(sigma, 0.005);
    EXPECT_LT(sigma, 0.2);
  }
  expect_pose(matches[0], there, 5.0 * matches[0].sigma_x, 5.0 * matches[0].sigma_angle_deg);
}

TEST(Search, PosesAtTheEndsOfTheRangeAreRefinedLikeAnyOther) {
  Finder finder({trained(options_for(20.0))}, {});
  for (const double angle : {-20.0, 20.0}) {
    const Pose there{160.0, 140.0, angle, 1.0, 1.0};
    const auto& found = finder.find(picture_of({there}, 6).view(), Mapping());
    ASSERT_EQ(found[0].matches.size(), 1U);
    expect_pose(found[0].matches[0], there, 0.02, 0.02);
  }
}

TEST(Search, ScalesOfBothAxes) {
  TrainOptions options = options_for(15.0);
  options.scale_x = {0.85, 1.15};
  options.scale_y = {0.85, 1.15};
  Finder finder({trained(options)}, {});
  const Pose there{158.6, 141.3, -8.0, 1.11, 0.91};
  const auto& found = finder.find(picture_of({there}, 7).view(), Mapping());
  ASSERT_EQ(found[0].matches.size(), 1U);
  expect_pose(found[0].matches[0], there, 0.05, 0.05);
  EXPECT_NEAR(found[0].matches[0].pose.scale_x, 1.11, 0.001);
  EXPECT_NEAR(found[0].matches[0].pose.scale_y, 0.91, 0.001);
}

TEST(Search, EveryInstanceOnce) {
  SearchOptions options;
  options.max_instances = 0;
  Finder finder({trained(options_for(30.0))}, options);
  const std::vector<Pose> places{{120, 110, 5, 1, 1}, {330, 130, -25, 1, 1}, {220, 320, 28, 1, 1}};
  const auto& found = finder.find(picture_of(places, 8, 480, 420).view(), Mapping());
  ASSERT_EQ(found[0].matches.size(), places.size());
  for (const Pose& place : places) {
    int near = 0;
    for (const Match& match : found[0].matches) {
      if (std::hypot(match.pose.x - truth(place).x, match.pose.y - truth(place).y) < 0.1) ++near;
    }
    EXPECT_EQ(near, 1);
  }
  EXPECT_GE(found[0].matches[0].score, 0.9);
}

TEST(Search, NothingWhereThereIsNothing) {
  Finder finder({trained(options_for(30.0))}, {});
  EXPECT_TRUE(finder.find(picture_of({}, 9).view(), Mapping())[0].matches.empty());
}

TEST(Search, TheRegionLimitsTheOrigin) {
  const Pose there{160.0, 140.0, 0.0, 1.0, 1.0};
  const Picture picture = picture_of({there}, 10);
  const auto pattern = trained(options_for(10.0));
  SearchOptions inside;
  inside.region = Roi{150, 130, 20, 20};
  SearchOptions elsewhere;
  elsewhere.region = Roi{10, 10, 100, 100};
  EXPECT_EQ(Finder({pattern}, inside).find(picture.view(), Mapping())[0].matches.size(), 1U);
  EXPECT_TRUE(Finder({pattern}, elsewhere).find(picture.view(), Mapping())[0].matches.empty());
}

TEST(Search, TheResultDoesNotDependOnTheThreads) {
  const auto pattern = trained(options_for(45.0));
  const Picture picture = picture_of({{165.2, 137.9, 31.0, 1.0, 1.0}}, 11);
  SearchOptions options;
  Finder one({pattern}, options);
  const Match alone = one.find(picture.view(), Mapping())[0].matches.at(0);
  for (const int threads : {2, 3}) {
    options.threads = threads;
    Finder several({pattern}, options);
    for (int round = 0; round < 3; ++round) {
      const Match match = several.find(picture.view(), Mapping())[0].matches.at(0);
      EXPECT_EQ(match.pose.x, alone.pose.x);
      EXPECT_EQ(match.pose.y, alone.pose.y);
      EXPECT_EQ(match.pose.angle_deg, alone.pose.angle_deg);
      EXPECT_EQ(match.score, alone.score);
      EXPECT_EQ(match.sigma_x, alone.sigma_x);
      EXPECT_EQ(match.visible, alone.visible);
    }
  }
}

TEST(Search, DeepPicturesAreReadWithAllTheirBits) {
  const Picture picture = picture_of({train_pose}, 12, 320, 280, 12);
  const auto pattern = std::make_shared<const Pattern>(train(picture.view(), Mapping(), options_for(10.0)));
  const Pose there{166.4, 138.2, 4.0, 1.0, 1.0};
  Finder finder({pattern}, {});
  const auto& found = finder.find(picture_of({there}, 13, 320, 280, 12).view(), Mapping());
  ASSERT_EQ(found[0].matches.size(), 1U);
  expect_pose(found[0].matches[0], there, 0.02, 0.02);
}

TEST(Search, BothFieldsOfAFrameGiveFrameCoordinates) {
  const auto pattern = trained(options_for(20.0));
  const Pose there{158.7, 139.2, 9.0, 1.0, 1.0};
  const Picture picture = picture_of({there}, 14);
  Finder finder({pattern}, {});
  for (const Field field : {Field::top, Field::bottom}) {
    const auto& found = finder.find(field_view(picture.view(), field), Mapping().for_field(field));
    ASSERT_EQ(found[0].matches.size(), 1U) << name(field);
    expect_pose(found[0].matches[0], there, 0.1, 0.1);
    EXPECT_NEAR(found[0].matches[0].frame_position.y(), found[0].matches[0].pose.y, 1e-9);
  }
}

TEST(Search, ReversedContrastIsFoundWhereAskedFor) {
  const Picture picture = picture_of({{160.0, 140.0, 12.0, 1.0, 1.0}}, 15);
  std::vector<std::uint8_t> negative;
  for (int y = 0; y < picture.view().height; ++y) {
    for (int x = 0; x < picture.view().width; ++x) {
      negative.push_back(static_cast<std::uint8_t>(255 - picture.view().at(x, y)));
    }
  }
  const ImageView view{reinterpret_cast<const std::byte*>(negative.data()), 320, 280, 320, 8};
  EXPECT_TRUE(Finder({trained(options_for(20.0))}, {}).find(view, Mapping())[0].matches.empty());
  TrainOptions any = options_for(20.0);
  any.polarity = Polarity::any;
  Finder finder({trained(any)}, {});
  const auto& found = finder.find(view, Mapping());
  ASSERT_EQ(found[0].matches.size(), 1U);
  EXPECT_EQ(found[0].matches[0].polarity, Polarity::reversed);
}

TEST(Search, AnyImageIsSearchedWithoutAnException) {
  TrainOptions wide = options_for(180.0);
  Finder finder({trained(wide)}, {});
  for (const auto& [width, height] : {std::pair(1, 1), {1, 300}, {300, 1}, {9, 9}, {64, 64}, {200, 17}}) {
    for (const std::uint8_t grey : {std::uint8_t{0}, std::uint8_t{128}, std::uint8_t{255}}) {
      const std::vector<std::uint8_t> pixels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), grey);
      const ImageView view{reinterpret_cast<const std::byte*>(pixels.data()), width, height, width, 8};
      EXPECT_TRUE(finder.find(view, Mapping())[0].matches.empty()) << width << " x " << height;
    }
  }
  EXPECT_TRUE(finder.find({}, Mapping())[0].matches.empty());
}

TEST(Search, SeveralPatternsEachAnswer) {
  TrainOptions second = options_for(20.0);
  second.name = "corner";
  second.roi = {100, 90, 60, 60};
  const auto a = trained(options_for(20.0));
  const auto b = trained(second);
  Finder finder({a, b}, {});
  const Pose there{170.0, 145.0, -7.0, 1.0, 1.0};
  const auto& found = finder.find(picture_of({there}, 16).view(), Mapping());
  ASSERT_EQ(found.size(), 2U);
  ASSERT_EQ(found[0].matches.size(), 1U);
  ASSERT_EQ(found[1].matches.size(), 1U);
  const Pose corner = render::expected_pose(train_pose, there, render::roi_centre(second.roi));
  EXPECT_NEAR(found[1].matches[0].pose.x, corner.x, 0.05);
  EXPECT_NEAR(found[1].matches[0].pose.y, corner.y, 0.05);
}

template <typename Change>
std::string complaint(Change change) {
  TrainOptions options = options_for(10.0);
  change(options);
  try {
    trained(options);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

TEST(Train, BadOptionsAreNamedWithTheirBounds) {
  EXPECT_THAT(complaint([](TrainOptions& o) { o.roi = {300, 10, 50, 50}; }), testing::HasSubstr("outside the image"));
  EXPECT_THAT(complaint([](TrainOptions& o) { o.roi = {10, 10, 3, 50}; }), testing::HasSubstr("too small"));
  EXPECT_THAT(complaint([](TrainOptions& o) { o.roi = {2147483000, 10, 2000, 50}; }), testing::HasSubstr("outside"));
  EXPECT_THAT(complaint([](TrainOptions& o) { o.angle_deg = {5.0, -5.0}; }), testing::HasSubstr("angle"));
  EXPECT_THAT(complaint([](TrainOptions& o) { o.angle_deg = {-300.0, 300.0}; }), testing::HasSubstr("full circle"));
  EXPECT_THAT(complaint([](TrainOptions& o) { o.scale_x = {0.1, 1.0}; }), testing::HasSubstr("scale_x"));
  EXPECT_THAT(complaint([](TrainOptions& o) { o.accuracy = 0; }), testing::HasSubstr("1 to 100"));
  EXPECT_THAT(complaint([](TrainOptions& o) { o.roi = {1, 1, 30, 30}; }), testing::HasSubstr("flat"));
  const std::vector<std::uint8_t> mask(100, 255);
  EXPECT_THAT(complaint([&](TrainOptions& o) {
                o.mask = {reinterpret_cast<const std::byte*>(mask.data()), 10, 10, 10, 8};
              }),
              testing::HasSubstr("mask"));
}

TEST(Train, TheMaskKeepsPointsInside) {
  std::vector<std::uint8_t> mask(150 * 130, 0);
  for (int y = 0; y < 130; ++y) {
    for (int x = 0; x < 75; ++x) mask[static_cast<std::size_t>(y * 150 + x)] = 1;
  }
  TrainOptions options = options_for(10.0);
  options.mask = {reinterpret_cast<const std::byte*>(mask.data()), 150, 130, 150, 8};
  const auto pattern = trained(options);
  for (const PointSet& set : pattern->sets) {
    EXPECT_FALSE(set.points.empty());
    for (const PatternPoint& point : set.points) EXPECT_LE(point.x, 0.51);
  }
}

TEST(Finder, BadOptionsAreNamedWithTheirBounds) {
  const auto pattern = trained(options_for(10.0));
  const auto refused = [&](auto change) {
    SearchOptions options;
    change(options);
    EXPECT_THROW(Finder({pattern}, options), UsageError);
  };
  refused([](SearchOptions& o) { o.min_score = 1.5; });
  refused([](SearchOptions& o) { o.min_score = std::nan(""); });
  refused([](SearchOptions& o) { o.max_overlap = -0.1; });
  refused([](SearchOptions& o) { o.max_instances = -1; });
  refused([](SearchOptions& o) { o.threads = 0; });
  refused([](SearchOptions& o) { o.angle_deg = Range{-20.0, 20.0}; });
  refused([](SearchOptions& o) { o.scale_x = Range{0.9, 1.0}; });
  refused([](SearchOptions& o) { o.region = Roi{0, 0, 0, 5}; });
  refused([](SearchOptions& o) { o.timeout_ms = -1.0; });
}

}  // namespace
}  // namespace vsfind
