/// The line fitter and the fiducials on rendered squares of exactly known place.
#include "app/qualify/edge_line.h"

#include <gtest/gtest.h>

#include <cmath>

#include "app/qualify/fiducials.h"
#include "app/qualify/square_finder.h"
#include "app/render/patterns.h"
#include "app/render/sensor.h"
#include "app/report/spread.h"

namespace vsfind {
namespace {

render::Picture square_at(const Pose& pose, double noise, std::uint64_t seed = 1, double dark = 40.0,
                          double light = 200.0, int bits = 8, Field field = Field::frame) {
  render::Scene scene;
  scene.width = 160;
  scene.height = 120;
  scene.background = light;
  scene.items.push_back({{{{{render::rectangle(-25.0, -25.0, 25.0, 25.0)}, dark}}, 50.0, 50.0}, pose});
  render::Sensor sensor;
  sensor.noise = noise;
  sensor.seed = seed;
  sensor.bits = bits;
  return render::develop(render::expose(scene, 0.7, field), sensor);
}

MeasuredSquare measured(const render::Picture& picture, const Mapping& mapping = {}) {
  const ImageView view = picture.view();
  const auto squares = find_squares(view, mapping, {0, 0, view.width, view.height});
  EXPECT_EQ(squares.size(), 1U);
  if (squares.empty()) return {};
  const auto square = measure_square(view, mapping, squares[0]);
  EXPECT_TRUE(square.has_value());
  return square.value_or(MeasuredSquare{});
}

TEST(EdgeLine, SquareIsLocatedWithoutBiasAtAnyShiftAndAngle) {
  // Without noise only the rounding to 16 bits is left; the model's edge and the pixels' true one differ a little.
  for (const double angle : {0.0, 3.0, 17.0, 44.0}) {
    for (const double shift : {0.0, 0.27, 0.5}) {
      const Pose pose{79.0 + shift, 60.3 - shift / 2.0, angle, 1.0, 1.0};
      const MeasuredSquare square = measured(square_at(pose, 0.0, 1, 40.0, 200.0, 16));
      EXPECT_NEAR(square.centre.x(), pose.x, 2e-4) << angle << " " << shift;
      EXPECT_NEAR(square.centre.y(), pose.y, 2e-4) << angle << " " << shift;
      for (std::size_t i = 0; i < square.corners.size(); ++i) {
        EXPECT_NEAR((square.corners[i] - square.centre).norm(), 25.0 * std::sqrt(2.0), 2e-3);
      }
    }
  }
}

TEST(EdgeLine, ScatterIsWhatTheFitPredicts) {
  std::vector<double> x;
  double predicted = 0.0;
  constexpr int repeats = 60;
  for (int i = 0; i < repeats; ++i) {
    const MeasuredSquare square =
        measured(square_at({79.3, 60.6, 5.0, 1.0, 1.0}, 2.0, static_cast<std::uint64_t>(10 + i)));
    x.push_back(square.centre.x());
    x.push_back(square.centre.y() - 60.6 + 79.3);
    predicted += square.sigma / repeats;
  }
  const double sd = spread_of(x).sd;
  EXPECT_GT(sd, 0.75 * predicted);
  EXPECT_LT(sd, 1.33 * predicted);
  EXPECT_LT(sd, 0.004);
}

TEST(EdgeLine, LightSquareOnDarkAndSixteenBits) {
  const MeasuredSquare square = measured(square_at({79.3, 60.6, -8.0, 1.0, 1.0}, 1.0, 3, 220.0, 60.0, 12));
  EXPECT_NEAR(square.centre.x(), 79.3, 0.01);
  EXPECT_NEAR(square.centre.y(), 60.6, 0.01);
}

TEST(EdgeLine, SquareOfAFieldInFrameCoordinates) {
  for (const Field field : {Field::top, Field::bottom}) {
    const MeasuredSquare square =
        measured(square_at({79.3, 60.6, 4.0, 1.0, 1.0}, 1.0, 3, 40.0, 200.0, 8, field), Mapping().for_field(field));
    EXPECT_NEAR(square.centre.x(), 79.3, 0.02) << name(field);
    EXPECT_NEAR(square.centre.y(), 60.6, 0.02) << name(field);
  }
}

TEST(EdgeLine, NothingWhereThereIsNoEdge) {
  const render::Picture plain = square_at({500.0, 500.0, 0.0, 1.0, 1.0}, 2.0);
  EXPECT_FALSE(fit_edge_line(plain.view(), {}, {40.0, 40.0}, {90.0, 42.0}, 6.0, 12.0));
  EXPECT_TRUE(find_squares(plain.view(), {}, {0, 0, 160, 120}).empty());
  EXPECT_FALSE(fit_edge_line({}, {}, {40.0, 40.0}, {90.0, 42.0}, 6.0, 12.0));
  EXPECT_FALSE(fit_edge_line(plain.view(), {}, {-500.0, -400.0}, {-450.0, -400.0}, 6.0, 12.0));
}

TEST(EdgeLine, FourSquaresAroundAPlace) {
  render::Scene sheet = render::target_sheet();
  sheet.items.push_back({render::bullseye(), {319.5, 239.5, 0.0, 1.0, 1.0}});
  // A fifth square of the same size, not a corner of the widest four.
  sheet.items.push_back(
      {{{{{render::rectangle(-25.0, -25.0, 25.0, 25.0)}, 40.0}}, 50.0, 50.0}, {140.0, 240.0, 0.0, 1.0, 1.0}});
  const render::Picture picture = render::develop(render::expose(sheet, 0.7), {});
  const auto all = find_squares(picture.view(), {}, {0, 0, 640, 480});
  EXPECT_GE(all.size(), 6U);
  const auto four = four_around(all, {319.5, 239.5}, 95.0);
  ASSERT_EQ(four.size(), 4U);
  const std::vector<Eigen::Vector2d> expected{{50.0, 50.0}, {589.0, 50.0}, {589.0, 429.0}, {50.0, 429.0}};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_LT((four[i].centre - expected[i]).norm(), 2.0) << i;
  EXPECT_TRUE(four_around(all, {20.0, 20.0}, 5.0).empty());
}

TEST(EdgeLine, FiducialsAreFollowedAndTurned) {
  const auto picture = [](double angle, double shift) {
    render::Scene sheet = render::target_sheet();
    for (auto& item : sheet.items) {
      const Pose turn{319.5 + shift, 239.5, angle, 1.0, 1.0};
      const Eigen::Vector2d place = plane_from_pattern(turn, {item.pose.x - 319.5, item.pose.y - 239.5});
      item.pose = {place.x(), place.y(), angle, 1.0, 1.0};
    }
    render::Sensor sensor;
    sensor.noise = 1.0;
    return render::develop(render::expose(sheet, 0.7), sensor);
  };
  const render::Picture first = picture(0.0, 0.0);
  FiducialTracker tracker(four_around(find_squares(first.view(), {}, {0, 0, 640, 480}), {319.5, 239.5}, 95.0));
  const auto start = tracker.measure(first.view(), {});
  ASSERT_TRUE(start);
  EXPECT_NEAR(start->angle_deg, 0.0, 1e-9);
  const auto moved = tracker.measure(picture(2.0, 7.0).view(), {});
  ASSERT_TRUE(moved);
  EXPECT_NEAR(moved->angle_deg, 2.0, 0.002);
  EXPECT_NEAR(moved->centre.x() - start->centre.x(), 7.0, 0.01);
  // A square out of sight is not guessed.
  const render::Picture empty(640, 480, 8);
  EXPECT_FALSE(tracker.measure(empty.view(), {}));
}

}  // namespace
}  // namespace vsfind
