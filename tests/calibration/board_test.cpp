// Boards rendered with a known camera: what comes out is what went in.
#include "calibration/board.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/calib3d.hpp>

#include "acquisition/errors.h"
#include "app/render/random.h"
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
  const std::vector<PlanePose> poses = board_poses(spec, 8, 32.0, 480.0);
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

// The same corners through OpenCV's own calibration give the same camera, and its distances are no smaller.
TEST(Boards, SolveLikeOpenCvsCalibrateCamera) {
  const BoardSpec spec = board("chessboard:9x6", 25.0);
  const std::vector<BoardView> views = views_of(spec, board_poses(spec, 6, 32.0, 480.0), camera_lens(), Field::frame);
  const Solution solution = solve_views(views, options_640());
  std::vector<std::vector<cv::Point3f>> object;
  std::vector<std::vector<cv::Point2f>> image;
  for (const BoardView& view : views) {
    object.emplace_back();
    image.emplace_back();
    for (const auto& p : view.board)
      object.back().emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()), 0.0F);
    for (const auto& p : view.frame) image.back().emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  }
  cv::Mat camera, coefficients;
  std::vector<cv::Mat> rotations, translations;
  const double rms = cv::calibrateCamera(object, image, {640, 480}, camera, coefficients, rotations, translations);
  const PinholeCamera& c = solution.calibration.lens->camera();
  EXPECT_NEAR(c.fx, camera.at<double>(0, 0), 0.05);
  EXPECT_NEAR(c.cy, camera.at<double>(1, 2), 0.05);
  EXPECT_NEAR(solution.calibration.lens->coefficients()[0], coefficients.at<double>(0), 1e-3);
  EXPECT_NEAR(solution.calibration.residuals.rms, rms, 1e-4);
}

TEST(Boards, OneViewGivesThePlaneAlone) {
  const BoardSpec spec = board("chessboard:9x6", 25.0);
  const Lens straight = test::lens_of(LensModel::polynomial, {});
  const std::vector<PlanePose> poses = board_poses(spec, 1, 32.0, 480.0);
  const std::vector<BoardView> views = views_of(spec, poses, straight, Field::frame);
  const Solution solution = solve_views(views, options_640());
  ASSERT_TRUE(solution.calibration.homography.has_value());
  EXPECT_FALSE(solution.calibration.lens.has_value());
  EXPECT_LT(largest_distance(spec, mapping_of(solution.calibration), Mapping::from_lens(straight, poses[0])), 0.02);
  EXPECT_TRUE(solution.warnings.empty());
  // Through a lens that bends lines a flat plane does not fit, which is said.
  const Solution bent = solve_views(views_of(spec, poses, camera_lens(), Field::frame), options_640());
  ASSERT_EQ(bent.warnings.size(), 1U);
  EXPECT_THAT(bent.warnings[0], HasSubstr("the lens bends lines"));
}

TEST(Boards, AKnownLensAndOneViewGiveThePlane) {
  const BoardSpec spec = board("circles:9x7", 25.0);
  for (const LensModel model : {LensModel::polynomial, LensModel::fisheye}) {
    const Lens lens = model == LensModel::fisheye ? test::lens_of(model, {-0.02, 0.01, -0.004, 0.001}) : camera_lens();
    const std::vector<PlanePose> poses = board_poses(spec, 1, 32.0, 480.0);
    SolveOptions options = options_640();
    options.lens = lens;
    const Solution solution = solve_views(views_of(spec, poses, lens, Field::top), options);
    EXPECT_LT(largest_distance(spec, mapping_of(solution.calibration), Mapping::from_lens(lens, poses[0])), 0.02);
    EXPECT_FALSE(solution.uncertainty.has_value());
  }
}

std::string refusal(const std::vector<BoardView>& views) {
  try {
    (void)solve_views(views, options_640());
  } catch (const UsageError& error) {
    return error.what();
  }
  return "no UsageError";
}

// Exact corners with a measuring error, without pictures.
std::vector<BoardView> made_up_views(const std::vector<PlanePose>& poses, double noise) {
  render::Random random(3);
  std::vector<BoardView> views;
  for (const PlanePose& pose : poses) {
    BoardView& view = views.emplace_back();
    view.name = "view " + std::to_string(views.size() - 1);
    const Mapping mapping = Mapping::from_lens(camera_lens(), pose);
    for (int i = 0; i < 54; ++i) {
      view.board.emplace_back(i % 9 * 25.0, i / 9 * 25.0);
      view.frame.emplace_back(mapping.image_from_plane(view.board.back()) +
                              noise * Eigen::Vector2d(random.normal(), random.normal()));
    }
  }
  return views;
}

TEST(Boards, ViewsThatCannotDetermineTheLensAreRefused) {
  const BoardSpec spec = board("chessboard:9x6", 25.0);
  EXPECT_THAT(refusal(made_up_views(board_poses(spec, 8, 0.0, 480.0), 0.05)),
              HasSubstr("cannot determine the lens: the board stands at the same slant"));
  // All tilted alike.
  std::vector<PlanePose> alike = board_poses(spec, 8, 30.0, 480.0);
  for (PlanePose& pose : alike) pose.rotation = alike[0].rotation;
  EXPECT_THAT(refusal(made_up_views(alike, 0.02)), HasSubstr("cannot determine the lens"));
  EXPECT_THAT(refusal(made_up_views(board_poses(spec, 5, 4.0, 480.0), 0.8)), HasSubstr("cannot determine the lens"));
  EXPECT_EQ(refusal(made_up_views(board_poses(spec, 8, 30.0, 480.0), 0.05)), "no UsageError");
  EXPECT_EQ(refusal({}), "no picture shows the board");
}

TEST(Boards, DoubtsAreSaid) {
  const BoardSpec spec = board("chessboard:9x6", 25.0);
  const auto warnings = [](const std::vector<BoardView>& views) {
    std::string all;
    for (const auto& w : solve_views(views, options_640()).warnings) all += w + "\n";
    return all;
  };
  EXPECT_EQ(warnings(made_up_views(board_poses(spec, 8, 32.0, 480.0), 0.02)), "");
  EXPECT_THAT(warnings(made_up_views(board_poses(spec, 3, 32.0, 480.0), 0.02)),
              HasSubstr("3 views are few for a lens"));
  EXPECT_THAT(warnings(made_up_views(board_poses(spec, 8, 5.0, 480.0), 0.02)),
              HasSubstr("slant of the board varies by"));
  EXPECT_THAT(warnings(made_up_views(board_poses(spec, 8, 32.0, 1500.0), 0.02)), HasSubstr("% of the image: outside"));
  std::vector<BoardView> wrong = made_up_views(board_poses(spec, 8, 32.0, 480.0), 0.05);
  wrong[3].frame[10].x() += 6.0;
  EXPECT_THAT(warnings(wrong), HasSubstr("view 3: fits"));
}

TEST(Boards, CoveredPartIsMeasured) {
  BoardView view;
  view.frame = {{-0.5, -0.5}, {319.5, -0.5}, {319.5, 239.5}, {-0.5, 239.5}, {100, 100}, {200, 50}};
  for (const auto& p : view.frame) view.board.emplace_back(p);
  EXPECT_NEAR(solve_views({view}, options_640()).covered, 0.25, 0.01);
}

// A frame whose fields see the board in the same place is a picture of the board; in two places it is none.
TEST(Boards, CombedPicturesAreRefused) {
  const BoardSpec spec = board("chessboard:9x6", 25.0);
  const BoardSpec circles = board("circles:9x7", 25.0);
  const PlanePose still = board_poses(spec, 1, 25.0, 480.0)[0];
  const auto mapping = [](const PlanePose& pose) { return Mapping::from_lens(camera_lens(), pose); };
  for (const BoardSpec& which : {spec, circles}) {
    const auto quiet = test::woven_picture(which, mapping(still), mapping(still));
    const auto found = find_board(quiet.view(), Field::frame, which, "quiet");
    ASSERT_TRUE(found.has_value());
    // Of circles the centre of area is not where the centre projects.
    const double allowed = which.kind == BoardKind::chessboard ? 0.1 : 0.2;
    EXPECT_LT(largest_corner_error(*found, mapping(still)), allowed);
    // From under a pixel to more than a square, across the lines and along them.
    const bool circular = which.kind == BoardKind::circles;
    for (const double pixels : circular ? std::vector<double>{11.0} : std::vector<double>{0.7, 60.0}) {
      PlanePose moved = still;
      moved.translation[static_cast<int>(pixels) % 2] += pixels * 480.0 / 800.0;
      SCOPED_TRACE(pixels);
      const auto combed = test::woven_picture(which, mapping(still), mapping(moved));
      try {
        const bool seen = find_board(combed.view(), Field::frame, which, "combed.png").has_value();
        ADD_FAILURE() << "not noticed; board " << (seen ? "found" : "not found");
      } catch (const UsageError& error) {
        EXPECT_THAT(error.what(), HasSubstr("combed.png: the two fields of this interlaced picture see the board"));
      }
      // Each of its fields is a good picture.
      const auto top = render::field_picture(combed, Field::top);
      const auto view = find_board(top.view(), Field::top, which, "top");
      ASSERT_TRUE(view.has_value());
      EXPECT_LT(largest_corner_error(*view, mapping(still)), allowed);
    }
  }
}

// A board that looks the same after half a turn: a little to this or that side of upright makes no difference.
TEST(Boards, XPointsRightOrDown) {
  const BoardSpec spec = board("chessboard:9x6", 20.0);
  for (const double turn : {-88.0, 92.0, 178.0, 30.0}) {
    PlanePose pose = test::slanted_plane(0.0, 0.0, turn, 480.0);
    pose.translation -= pose.rotation.leftCols<2>() * test::board_middle(spec);
    const Mapping mapping = Mapping::from_lens(camera_lens(), pose);
    const auto view = find_board(board_picture(spec, mapping).view(), Field::frame, spec, "board");
    ASSERT_TRUE(view.has_value()) << turn;
    Eigen::Vector2d x = Eigen::Vector2d::Zero();
    for (std::size_t i = 0; i < view->frame.size(); ++i) x += (view->board[i].x() - 80.0) * view->frame[i];
    x.normalize();
    const double expected = turn == 30.0 ? 30.0 : turn == 178.0 ? -2.0 : 92.0;
    EXPECT_NEAR(std::atan2(x.y(), x.x()) * 57.29578, expected, 1.0) << turn;
  }
}

// Before any fitting the detectors' places are right on average, in frame pixels whatever the lines.
TEST(Boards, DetectorsCountFrameLines) {
  const BoardSpec spec = board("chessboard:9x6", 25.0);
  const Mapping mapping = Mapping::from_lens(camera_lens(), board_poses(spec, 1, 25.0, 480.0)[0]);
  for (const Field lines : {Field::frame, Field::top, Field::bottom}) {
    const auto picture = board_picture(spec, mapping, lines);
    const DetectedGrid grid = detect_grid(picture.view(), lines, spec);
    ASSERT_EQ(grid.points.size(), 54U) << name(lines);
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (const GridPoint& p : grid.points) {
      mean += (p.frame - mapping.image_from_plane(Eigen::Vector2d(p.column * 25.0, p.row * 25.0))) / 54.0;
    }
    EXPECT_LT(mean.norm(), 0.25) << name(lines) << ": " << mean.transpose();
  }
}

TEST(Boards, NothingIsFoundWhereThereIsNone) {
  const std::vector<std::byte> grey(std::size_t{640} * 480, std::byte{128});
  for (const char* text : {"chessboard:9x6", "circles:9x7", "charuco:8x6"}) {
    for (const int height : {480, 7, 1}) {
      const ImageView image{grey.data(), 640, height, 640, 8};
      EXPECT_FALSE(find_board(image, Field::frame, board(text, 1.0), "grey").has_value());
      EXPECT_FALSE(find_board(image, Field::top, board(text, 1.0), "grey").has_value());
    }
    EXPECT_FALSE(find_board(ImageView{}, Field::frame, board(text, 1.0), "empty").has_value());
  }
}

TEST(Boards, SixteenBitPicturesAreBoardsToo) {
  const BoardSpec spec = board("chessboard:9x6", 25.0);
  const PlanePose pose = board_poses(spec, 1, 25.0, 480.0)[0];
  const auto eight = board_picture(spec, Mapping::from_lens(camera_lens(), pose));
  render::Picture twelve(640, 480, 12);
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) twelve.set(x, y, eight.view().at(x, y) * 16);
  }
  const auto a = find_board(eight.view(), Field::frame, spec, "8");
  const auto b = find_board(twelve.view(), Field::frame, spec, "12");
  ASSERT_TRUE(a && b);
  ASSERT_EQ(a->frame.size(), b->frame.size());
  for (std::size_t i = 0; i < a->frame.size(); ++i) EXPECT_LT((a->frame[i] - b->frame[i]).norm(), 0.02);
}

TEST(Boards, NamesAreRead) {
  const BoardSpec spec = parse_board("circles:12x7");
  EXPECT_EQ(spec.kind, BoardKind::circles);
  EXPECT_EQ(spec.columns, 12);
  EXPECT_EQ(spec.rows, 7);
  for (const char* text :
       {"", "chessboard", "chessboard:", "chessboard:9", "chessboard:9x", "chessboard:x6", "chess:9x6", "circles:2x9",
        "circles:9x101", "charuco:9x6x5", "charuco:-9x6", "charuco:1e1x6"}) {
    EXPECT_THROW((void)parse_board(text), UsageError) << text;
  }
}

}  // namespace
}  // namespace vsfind
