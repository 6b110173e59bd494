// Boards rendered with a known camera: what comes out is what went in.
#include "calibration/board.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/calib3d.hpp>

#include "acquisition/errors.h"
#include "calibration/board_detect.h"
#include "calibration/solve.h"
#include "tests/calibration/cameras.h"
#include "tests/calibration/rendered_boards.h"

namespace vsfind {
namespace {

using test::board_picture;
using test::board_poses;
using testing::HasSubstr;

Lens camera_lens() { return test::lens_of(LensModel::polynomial, {-0.28, 0.10, 6e-4, -4e-4, -0.02}); }

BoardSpec board(const std::string& text, double pitch) {
  BoardSpec spec = parse_board(text);
  spec.pitch = pitch;
  return spec;
}

SolveOptions options_640() {
  SolveOptions options;
  options.image_width = 640;
  options.image_height = 480;
  return options;
}

std::vector<BoardView> views_of(const BoardSpec& spec, const std::vector<PlanePose>& poses, const Lens& lens,
                                Field lines) {
  std::vector<BoardView> views;
  for (const PlanePose& pose : poses) {
    const std::string name = "view " + std::to_string(views.size());
    const auto picture = board_picture(spec, Mapping::from_lens(lens, pose), lines, views.size() + 1);
    const auto view = find_board(picture.view(), lines, spec, name);
    EXPECT_TRUE(view.has_value()) << name;
    if (view) views.push_back(*view);
  }
  return views;
}

// The largest distance between where two mappings put points on the board, its border included; frame pixels.
double largest_distance(const BoardSpec& spec, const Mapping& a, const Mapping& b) {
  double largest = 0.0;
  for (double v = -1.0; v <= grid_rows(spec); v += 0.25) {
    for (double u = -1.0; u <= grid_columns(spec); u += 0.25) {
      const Eigen::Vector2d plane(u * spec.pitch, v * spec.pitch);
      const Eigen::Vector2d seen = b.image_from_plane(plane);
      EXPECT_TRUE(seen.x() > 0 && seen.x() < 639 && seen.y() > 0 && seen.y() < 479) << "the board leaves the image";
      largest = std::max(largest, (a.image_from_plane(plane) - seen).norm());
    }
  }
  return largest;
}

double largest_corner_error(const BoardView& view, const Mapping& truth) {
  double largest = 0.0;
  for (std::size_t i = 0; i < view.frame.size(); ++i) {
    largest = std::max(largest, (truth.image_from_plane(view.board[i]) - view.frame[i]).norm());
  }
  return largest;
}

struct Case {
  const char* name;
  const char* board;
  double pitch;
  Field lines;
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

class RenderedBoards : public testing::TestWithParam<Case> {};

TEST_P(RenderedBoards, GiveBackLensAndPlane) {
  const Case& c = GetParam();
  const BoardSpec spec = board(c.board, c.pitch);
  const std::vector<PlanePose> poses = board_poses(spec, 12, 32.0, 480.0);
  const std::vector<BoardView> views = views_of(spec, poses, camera_lens(), c.lines);
  ASSERT_EQ(views.size(), poses.size());
  double corner_error = 0.0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    corner_error = std::max(corner_error, largest_corner_error(views[i], Mapping::from_lens(camera_lens(), poses[i])));
  }
  SolveOptions options = options_640();
  options.plane_view = poses.size() - 1;
  options.made_from = c.lines;
  const Solution solution = solve_views(views, options);
  const PinholeCamera& solved = solution.calibration.lens->camera();
  const double distance =
      largest_distance(spec, mapping_of(solution.calibration), Mapping::from_lens(camera_lens(), poses.back()));
  std::printf("%s: corners %.4f px, rms %.4f, plane %.4f px, fx %.3f fy %.3f cx %.2f cy %.2f covered %.2f\n", c.name,
              corner_error, solution.calibration.residuals.rms, distance, solved.fx, solved.fy, solved.cx, solved.cy,
              solution.covered);
  for (const auto& w : solution.warnings) std::printf("  %s\n", w.c_str());
  EXPECT_NEAR(solved.fx / 800.0, 1.0, 1e-3);
  EXPECT_NEAR(solved.fy / 790.0, 1.0, 1e-3);
  EXPECT_LT(distance, 0.02);
}

INSTANTIATE_TEST_SUITE_P(All, RenderedBoards,
                         testing::Values(Case{"chessboard", "chessboard:9x6", 25.0, Field::frame},
                                         Case{"chessboard_top", "chessboard:9x6", 25.0, Field::top},
                                         Case{"chessboard_bottom", "chessboard:9x6", 25.0, Field::bottom},
                                         Case{"circles", "circles:9x7", 25.0, Field::frame},
                                         Case{"circles_top", "circles:9x7", 25.0, Field::top},
                                         Case{"charuco", "charuco:8x6", 33.0, Field::frame},
                                         Case{"charuco_bottom", "charuco:8x6", 33.0, Field::bottom}),
                         [](const auto& tested) { return std::string(tested.param.name); });

}  // namespace
}  // namespace vsfind
