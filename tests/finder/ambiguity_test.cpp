/// Patterns that cannot work are refused, or trained with a warning that names the direction; what looks like the
/// pattern is measured.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "acquisition/errors.h"
#include "app/render/patterns.h"
#include "app/render/sensor.h"
#include "finder/search.h"
#include "finder/train.h"
#include "finder/undetermined.h"

namespace vsfind {
namespace {

using render::Picture;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int side = 400;
constexpr Roi middle_roi{140, 140, 120, 120};

Picture picture_of(const std::vector<render::Item>& items, double background = 200.0) {
  render::Scene scene;
  scene.width = side;
  scene.height = side;
  scene.background = background;
  scene.items = items;
  render::Sensor sensor;
  sensor.seed = 1;
  return render::develop(render::expose(scene, 0.7), sensor);
}

render::Item at_middle(const render::Drawing& drawing, double angle = 0.0) {
  return {drawing, {200.3, 199.6, angle, 1.0, 1.0}};
}

render::Drawing plate(double width, double height) {
  return {{{{render::rectangle(-width / 2, -height / 2, width / 2, height / 2)}, 40.0}}, width, height};
}

/// Dark bars along y, right across the picture.
render::Drawing bars(double period) {
  render::Drawing drawing;
  for (double x = -400.0; x < 400.0; x += period) {
    drawing.shapes.push_back({{render::rectangle(x, -400.0, x + period / 2.0, 400.0)}, 40.0});
  }
  return drawing;
}

/// Discs all over the picture.
std::vector<render::Item> grid(double period_x, double period_y, double diameter) {
  std::vector<render::Item> items;
  for (double y = period_y / 2.0; y < side; y += period_y) {
    for (double x = period_x / 2.0; x < side; x += period_x) {
      items.push_back({render::disc(diameter), {x, y, 0.0, 1.0, 1.0}});
    }
  }
  return items;
}

TrainOptions options_for(double angle, const Roi& roi = middle_roi) {
  TrainOptions options;
  options.roi = roi;
  options.angle_deg = {-angle, angle};
  return options;
}

TrainReport report_of(const Picture& picture, const TrainOptions& options) {
  return train(picture.view(), Mapping(), options).report;
}

std::string refusal(const Picture& picture, const TrainOptions& options) {
  try {
    static_cast<void>(train(picture.view(), Mapping(), options));
  } catch (const UsageError& error) {
    EXPECT_THAT(error.what(), testing::Not(HasSubstr("\n")));
    return error.what();
  }
  return "";
}

TEST(Ambiguity, AFlatPatternIsRefused) {
  EXPECT_THAT(refusal(picture_of({}), options_for(0.0)), AllOf(HasSubstr("flat"), HasSubstr("at least 1")));
}

TEST(Ambiguity, ATinyPatternIsRefused) {
  EXPECT_THAT(refusal(picture_of({at_middle(render::disc(6))}), options_for(0.0, {198, 198, 4, 4})),
              AllOf(HasSubstr("too small"), HasSubstr("at least 8 x 8")));
}

TEST(Ambiguity, AMaskThatLeavesNothingIsRefused) {
  std::vector<std::uint8_t> mask(static_cast<std::size_t>(middle_roi.width * middle_roi.height), 0);
  TrainOptions options = options_for(0.0);
  options.mask = {reinterpret_cast<const std::byte*>(mask.data()), middle_roi.width, middle_roi.height,
                  middle_roi.width, 8};
  const Picture picture = picture_of({at_middle(render::disc(80))});
  EXPECT_THAT(refusal(picture, options), AllOf(HasSubstr("mask leaves 0 points"), HasSubstr("at least 16")));
  // Everywhere narrower than what a point reads.
  for (std::size_t y = 0; y < 120; y += 6) {
    for (std::size_t x = 0; x < 120; ++x) mask[y * 120 + x] = 1;
  }
  EXPECT_THAT(refusal(picture, options), HasSubstr("mask leaves"));
}

TEST(Ambiguity, BarsAreToldAcrossOnlyAndTheirPeriodIsNamed) {
  const TrainReport upright = report_of(picture_of({at_middle(bars(20.0))}), options_for(0.0));
  EXPECT_THAT(upright.warnings, ElementsAre(HasSubstr("no structure along y"), HasSubstr("every 20.0 pixels along x")));
  EXPECT_GT(upright.impostor_score, 0.95);
  const TrainReport lying = report_of(picture_of({at_middle(bars(26.0), 90.0)}), options_for(0.0));
  EXPECT_THAT(lying.warnings, ElementsAre(HasSubstr("no structure along x"), HasSubstr("every 26.0 pixels along y")));
  const TrainReport slanted = report_of(picture_of({at_middle(bars(20.0), 30.0)}), options_for(0.0));
  ASSERT_FALSE(slanted.warnings.empty());
  EXPECT_THAT(slanted.warnings[0], testing::ContainsRegex("no structure along 1(19|20|21) degrees"));
}

TEST(Ambiguity, AnEdgeSlidesAlongItself) {
  render::Drawing half;
  half.shapes.push_back({{render::rectangle(-400.0, -400.0, 0.0, 400.0)}, 40.0});
  const TrainReport report = report_of(picture_of({at_middle(half)}), options_for(0.0));
  EXPECT_THAT(report.warnings, ElementsAre(HasSubstr("no structure along y")));
}

TEST(Ambiguity, ADiscAskedForItsAngleIsWarnedOfAndItsPositionFound) {
  const Picture picture = picture_of({at_middle(render::disc(80))});
  EXPECT_THAT(report_of(picture, options_for(0.0)).warnings, IsEmpty());
  const auto pattern = std::make_shared<const Pattern>(train(picture.view(), Mapping(), options_for(180.0)));
  EXPECT_THAT(pattern->report.warnings, ElementsAre(HasSubstr("turned by any angle")));
  EXPECT_GT(pattern->report.impostor_score, 0.95);
  const Picture elsewhere = picture_of({{render::disc(80), {151.7, 263.2, 0.0, 1.0, 1.0}}});
  Finder finder({pattern}, {});
  const auto& matches = finder.find(elsewhere.view(), Mapping())[0].matches;
  ASSERT_EQ(matches.size(), 1U);
  // The origin lies 0.8 px and −0.1 px from the disc's centre, wherever the angle has turned it to.
  EXPECT_NEAR(std::hypot(matches[0].pose.x - 151.7, matches[0].pose.y - 263.2), std::hypot(0.8, 0.1), 0.02);
}

TEST(Ambiguity, SymmetriesWithinTheRangeAreNamedWithTheirAngle) {
  const auto warnings = [](const render::Drawing& drawing, double angle) {
    return report_of(picture_of({at_middle(drawing)}), options_for(angle)).warnings;
  };
  EXPECT_THAT(warnings(render::bullseye(100.0), 180.0), ElementsAre(HasSubstr("looks the same turned by 90 degrees")));
  EXPECT_THAT(warnings(plate(100.0, 50.0), 180.0), ElementsAre(HasSubstr("looks the same turned by 180 degrees")));
  // Within these ranges nothing else looks the same.
  EXPECT_THAT(warnings(render::bullseye(100.0), 45.0), IsEmpty());
  EXPECT_THAT(warnings(plate(100.0, 50.0), 60.0), IsEmpty());
  EXPECT_THAT(warnings(render::artwork(3, 110.0, 100.0), 180.0), IsEmpty());
}

TEST(Ambiguity, TheImpostorOfASymmetryIsMeasured) {
  const TrainReport square = report_of(picture_of({at_middle(render::bullseye(100.0))}), options_for(180.0));
  EXPECT_GT(square.impostor_score, 0.98);
  EXPECT_EQ(square.impostor, "turned by 90 degrees");
  const TrainReport artwork = report_of(picture_of({at_middle(render::artwork(3, 110.0, 100.0))}), options_for(180.0));
  EXPECT_LT(artwork.impostor_score, 0.8);
}

TEST(Ambiguity, AGridIsNamedWithItsPeriods) {
  const TrainReport square = report_of(picture_of(grid(24.0, 24.0, 14.0)), options_for(0.0));
  EXPECT_THAT(square.warnings, testing::UnorderedElementsAre(HasSubstr("every 24.0 pixels along x"),
                                                             HasSubstr("every 24.0 pixels along y")));
  EXPECT_GT(square.impostor_score, 0.95);
  const TrainReport oblong = report_of(picture_of(grid(40.0, 50.0, 24.0)), options_for(0.0));
  EXPECT_THAT(oblong.warnings, testing::UnorderedElementsAre(HasSubstr("every 40.0 pixels along x"),
                                                             HasSubstr("every 50.0 pixels along y")));
}

TEST(Ambiguity, ACellOfAGridIsWarnedOfItsNeighbours) {
  const TrainReport report = report_of(picture_of(grid(40.0, 40.0, 24.0)), options_for(0.0, {160, 160, 40, 40}));
  EXPECT_THAT(report.warnings, testing::UnorderedElementsAre(HasSubstr("every 40.0 pixels along x"),
                                                             HasSubstr("every 40.0 pixels along y")));
  EXPECT_GT(report.impostor_score, 0.95);
}

TEST(Ambiguity, TheSamePartElsewhereAndInOtherScenesIsNamedWithItsPlace) {
  const render::Drawing part = render::artwork(3, 100.0, 90.0);
  TrainOptions options = options_for(10.0, {45, 50, 110, 100});
  const Picture two = picture_of({{part, {100.0, 100.0, 0.0, 1.0, 1.0}}, {part, {300.0, 290.0, 0.0, 1.0, 1.0}}});
  EXPECT_THAT(report_of(two, options).warnings,
              ElementsAre(AllOf(HasSubstr("at 299.5, 289.5"), HasSubstr("the training picture"))));
  const Picture one = picture_of({{part, {100.0, 100.0, 0.0, 1.0, 1.0}}});
  EXPECT_THAT(report_of(one, options).warnings, IsEmpty());
  options.against = {two.view()};
  const TrainReport against = report_of(one, options);
  EXPECT_THAT(against.warnings, ElementsAre(HasSubstr("of scene 1 of those to tell it from")));
  EXPECT_GT(against.impostor_score, 0.95);
}

TEST(Ambiguity, ScalesThatCannotBeToldAreNamed) {
  std::vector<PatternPoint> points;
  for (int y = -20; y <= 20; ++y) {
    for (int x = -20; x <= 20; ++x) {
      PatternPoint p;
      p.x = x;
      p.y = y;
      p.value = static_cast<float>(100.0 + 50.0 * std::sin(0.4 * x));
      p.gradient_x = static_cast<float>(20.0 * std::cos(0.4 * x));
      p.laplacian = static_cast<float>(-8.0 * std::sin(0.4 * x));
      points.push_back(p);
    }
  }
  Freedom freedom;
  freedom.scale_x = true;
  freedom.scale_y = true;
  const Undetermined what = undetermined_by(points, freedom, 2.0);
  EXPECT_EQ(what.directions, 1);
  EXPECT_NEAR(what.direction_deg, 90.0, 0.1);
  EXPECT_FALSE(what.scale_x);
  EXPECT_TRUE(what.scale_y);
  EXPECT_THAT(warnings_of(what, freedom), ElementsAre(HasSubstr("along y"), HasSubstr("any scale_y")));
}

TEST(Ambiguity, TooManyTurnedAndScaledCopiesAreRefusedNamingTheRanges) {
  TrainOptions options = options_for(180.0, {10, 190, 380, 12});
  options.scale_x = {0.5, 2.0};
  options.scale_y = {0.5, 2.0};
  EXPECT_THAT(refusal(picture_of({at_middle(bars(37.0), 10.0)}), options),
              AllOf(HasSubstr("at most 65535"), HasSubstr("angle ("), HasSubstr("scale_x ("), HasSubstr("scale_y (")));
  options.angle_deg = {-5.0, 5.0};
  options.scale_y = {1.0, 1.0};
  options.scale_x = {1.0, 1.0};
  EXPECT_EQ(refusal(picture_of({at_middle(bars(37.0), 10.0)}), options), "");
}

}  // namespace
}  // namespace vsfind
