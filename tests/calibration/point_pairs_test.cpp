#include "calibration/point_pairs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "acquisition/errors.h"
#include "app/render/random.h"
#include "tests/calibration/cameras.h"

namespace vsfind {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::string complaint(const std::function<void()>& act) {
  try {
    act();
  } catch (const UsageError& error) {
    return error.what();
  }
  return "no UsageError";
}

std::string complaint_of(const std::string& text) {
  return complaint([&text] { (void)parse_point_pairs(text, "p.csv"); });
}

Mapping camera() {
  Eigen::Matrix3d h;
  h << 1.7, 0.2, 310.0, -0.15, 1.4, 250.0, 1.1e-4, -7e-4, 1.0;
  return Mapping::from_homography(h);
}

SolveOptions options_640() {
  SolveOptions options;
  options.image_width = 640;
  options.image_height = 480;
  return options;
}

// World points spread over the picture, seen by `mapping` with a measuring error of `noise` pixels.
std::vector<PointPair> pairs_of(const Mapping& mapping, int count, double noise) {
  render::Random random(7);
  std::vector<PointPair> pairs;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d world(random.uniform(-150.0, 150.0), random.uniform(-120.0, 120.0));
    const Eigen::Vector2d image =
        mapping.image_from_plane(world) + noise * Eigen::Vector2d(random.normal(), random.normal());
    pairs.push_back({image, world, i + 2});
  }
  return pairs;
}

double largest_distance(const Mapping& a, const Mapping& b) {
  double largest = 0.0;
  for (double y = -100.0; y <= 100.0; y += 50.0) {
    for (double x = -100.0; x <= 100.0; x += 50.0) {
      largest = std::max(
          largest, (a.image_from_plane(Eigen::Vector2d(x, y)) - b.image_from_plane(Eigen::Vector2d(x, y))).norm());
    }
  }
  return largest;
}

TEST(PointPairs, ReadsCsv) {
  const auto pairs =
      parse_point_pairs("\xef\xbb\xbf# by hand\nworld_x, image_x,image_y,world_y\r\n\n1,2.5,-3,+4e1\r\n", "p.csv");
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_EQ(pairs[0].image, Eigen::Vector2d(2.5, -3.0));
  EXPECT_EQ(pairs[0].world, Eigen::Vector2d(1.0, 40.0));
  EXPECT_EQ(pairs[0].line, 4);
}

TEST(PointPairs, ComplaintsNameLineAndColumn) {
  const std::string head = "image_x,image_y,world_x,world_y\n";
  EXPECT_EQ(complaint_of(""), "p.csv: empty: its first line must be image_x,image_y,world_x,world_y");
  EXPECT_EQ(complaint_of("image_x,image_y,world_x,word_y\n"),
            "p.csv:1: 'word_y' is no column (did you mean world_y?) (allowed: image_x,image_y,world_x,world_y)");
  EXPECT_THAT(complaint_of("image_x,image_y,world_x\n"), HasSubstr("p.csv:1: column world_y must be there once"));
  EXPECT_THAT(complaint_of(head + "1,2,3\n"), HasSubstr("p.csv:2: has 3 values, must have 4"));
  EXPECT_THAT(complaint_of(head + "1,2,3,4\n1,2,x,4\n"), HasSubstr("p.csv:3: world_x: 'x' is no number"));
  EXPECT_THAT(complaint_of(head + "1,2,3,nan\n"), HasSubstr("world_y"));
  EXPECT_THAT(complaint_of(head + "1,2,3,\n"), HasSubstr("world_y"));
  EXPECT_THAT(complaint_of(std::string(100000, ',')), HasSubstr("p.csv:1"));
  std::string many = head;
  for (int i = 0; i < 10001; ++i) many += "1,2,3,4\n";
  EXPECT_THAT(complaint_of(many), HasSubstr("more than 10000 points"));
}

TEST(PointPairs, FourAreMetExactly) {
  const std::vector<PointPair> pairs{
      {{10.25, 20.5}, {0, 0}, 2}, {{600.5, 35}, {200, 0}, 3}, {{620, 455}, {200, 150}, 4}, {{30, 430}, {0, 150}, 5}};
  BoardView used;
  const Solution solution = solve_points(pairs, options_640(), "p.csv", used);
  const Mapping mapping = mapping_of(solution.calibration);
  for (const PointPair& pair : pairs) {
    EXPECT_LT((mapping.image_from_plane(pair.world) - pair.image).norm(), 1e-9);
    EXPECT_LT((mapping.plane_from_image(pair.image) - pair.world).norm(), 1e-9);
  }
  EXPECT_THAT(solution.warnings, IsEmpty());
}

TEST(PointPairs, PointsOutsideThePictureAreDoubted) {
  std::vector<PointPair> pairs{{{0, 0}, {0, 0}, 2}, {{640, 0}, {200, 0}, 3}, {{640, 480}, {200, 150}, 4}};
  pairs.push_back({{0, 480}, {0, 150}, 5});
  BoardView used;
  EXPECT_THAT(solve_points(pairs, options_640(), "p.csv", used).warnings, IsEmpty());
  pairs[3].image.y() = 4800.0;
  EXPECT_THAT(solve_points(pairs, options_640(), "p.csv", used).warnings,
              ElementsAre("p.csv:5: the image point 0,4800 lies outside the picture of 640x480"));
  SolveOptions fields = options_640();
  fields.made_from = Field::top;
  pairs[3].image.y() = 400.0;
  EXPECT_THAT(solve_points(pairs, fields, "p.csv", used).warnings,
              ElementsAre(HasSubstr("p.csv:4: the image point 640,480 lies outside the picture of 640x240"),
                          HasSubstr("p.csv:5: the image point 0,400 lies outside the picture of 640x240")));
}

TEST(PointPairs, FieldsCountTheirOwnRows) {
  std::vector<PointPair> pairs = pairs_of(camera().for_field(Field::bottom), 4, 0.0);
  SolveOptions options = options_640();
  options.made_from = Field::bottom;
  BoardView used;
  const Solution solution = solve_points(pairs, options, "p.csv", used);
  EXPECT_LT(largest_distance(mapping_of(solution.calibration), camera()), 1e-7);
}

TEST(PointPairs, RefusesWhatDeterminesNoPlane) {
  BoardView used;
  const auto solve = [&used](const std::vector<PointPair>& pairs) {
    return complaint([&] { (void)solve_points(pairs, options_640(), "p.csv", used); });
  };
  std::vector<PointPair> pairs{{{10, 20}, {0, 0}, 2}, {{600, 35}, {200, 0}, 3}, {{620, 455}, {200, 150}, 4}};
  EXPECT_EQ(solve(pairs), "p.csv: has 3 points, a plane needs at least four");
  pairs.push_back({{305, 27.5}, {100, 70}, 5});
  EXPECT_THAT(solve(pairs), HasSubstr("p.csv: the points of lines 2, 3 and 5 lie on one straight line in the image"));
  pairs[3] = {{300, 300}, {400, 300}, 5};
  EXPECT_THAT(solve(pairs), HasSubstr("lines 2, 4 and 5 lie on one straight line in the world"));
  pairs[3] = pairs[0];
  EXPECT_THAT(solve(pairs), HasSubstr("lie on one straight line"));
  // A bow tie: two neighbours exchanged.
  pairs = {{{10, 20}, {0, 0}, 2}, {{600, 35}, {0, 150}, 3}, {{620, 455}, {200, 150}, 4}, {{30, 430}, {200, 0}, 5}};
  EXPECT_EQ(solve(pairs), "no UsageError") << "a mirrored plane is one";
  std::swap(pairs[0].world, pairs[1].world);
  EXPECT_THAT(solve(pairs), HasSubstr("are two points swapped?"));
  // Many, all but one on a line.
  pairs.clear();
  for (int i = 0; i < 9; ++i) pairs.push_back({{10.0 + 50 * i, 20.0 + 30 * i}, {10.0 * i, 5.0 * i}, i + 2});
  pairs.push_back({{100, 400}, {10, 100}, 20});
  EXPECT_THAT(solve(pairs), HasSubstr("too many of them lie on one line"));
}

TEST(PointPairs, ManyAreFittedAndOutliersNamed) {
  for (const int count : {6, 10, 40}) {
    SCOPED_TRACE(count);
    std::vector<PointPair> pairs = pairs_of(camera(), count, 0.2);
    BoardView used;
    const Solution clean = solve_points(pairs, options_640(), "p.csv", used);
    EXPECT_THAT(clean.warnings, IsEmpty());
    EXPECT_EQ(used.frame.size(), pairs.size());
    EXPECT_LT(largest_distance(mapping_of(clean.calibration), camera()), 1.0);
    pairs[2].image.x() += 25.0;
    if (count > 6) std::swap(pairs[5].world.x(), pairs[5].world.y());
    const Solution solution = solve_points(pairs, options_640(), "p.csv", used);
    EXPECT_LT(largest_distance(mapping_of(solution.calibration), camera()), count > 6 ? 1.2 : 4.0);
    if (count > 6) {
      EXPECT_THAT(solution.warnings, ElementsAre(HasSubstr("p.csv:4: lies 2"), HasSubstr("p.csv:7: lies")));
    } else {
      EXPECT_THAT(solution.warnings, ElementsAre(HasSubstr("p.csv:4: lies 2")));
    }
  }
}

TEST(PointPairs, BeforeAKnownLensGiveThePlanesPose) {
  const Lens lens = test::lens_of(LensModel::polynomial, {-0.28, 0.10, 6e-4, -4e-4, -0.02});
  const PlanePose truth = test::slanted_plane(30.0, -12.0, 20.0, 500.0);
  const Mapping mapping = Mapping::from_lens(lens, truth);
  std::vector<PointPair> pairs = pairs_of(mapping, 12, 0.0);
  pairs[3].image.y() -= 9.0;
  SolveOptions options = options_640();
  options.lens = lens;
  BoardView used;
  const Solution solution = solve_points(pairs, options, "p.csv", used);
  EXPECT_LT((solution.calibration.plane->rotation - truth.rotation).norm(), 1e-8);
  EXPECT_LT((solution.calibration.plane->translation - truth.translation).norm(), 1e-5);
  EXPECT_THAT(solution.warnings, ElementsAre(HasSubstr("p.csv:5: lies 9.00 px")));
}

}  // namespace
}  // namespace vsfind
