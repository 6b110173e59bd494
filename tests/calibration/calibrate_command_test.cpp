// The program's `calibrate` from the outside: what it writes, what it says, how it ends.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "calibration/calibration_file.h"
#include "tests/app/shell.h"
#include "tests/calibration/cameras.h"
#include "tests/calibration/rendered_boards.h"

namespace vsfind {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Matcher;
using testing::StartsWith;

class CalibrateCommand : public testing::Test {
 protected:
  std::string file(const std::string& name) const { return folder_ / name; }

  /// `calibrate` with these options and -o out.yaml.
  test::Outcome calibrate(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "calibrate");
    arguments.insert(arguments.end(), {"-o", file("out.yaml")});
    return test::vsfind(arguments);
  }

  void expect_refused(const std::vector<std::string>& arguments, int code, const Matcher<std::string>& line) const {
    const test::Outcome outcome = calibrate(arguments);
    EXPECT_EQ(outcome.code, code) << outcome.err;
    EXPECT_EQ(test::lines_of(outcome.err).size(), 1U) << outcome.err;
    EXPECT_THAT(outcome.err, AllOf(StartsWith("vsfind: "), line));
    EXPECT_FALSE(std::filesystem::exists(file("out.yaml")));
  }

  /// A picture of a board through a known camera.
  std::string board_file(const std::string& name, const PlanePose& pose, Field lines = Field::frame) const {
    const auto picture = test::board_picture(spec(), Mapping::from_lens(lens(), pose), lines);
    const ImageView view = picture.view();
    cv::imwrite(file(name), cv::Mat(view.height, view.width, CV_8U, const_cast<std::byte*>(view.data)));
    return file(name);
  }

  static BoardSpec spec() {
    BoardSpec spec = parse_board("chessboard:9x6");
    spec.pitch = 25.0;
    return spec;
  }
  static Lens lens() { return test::lens_of(LensModel::polynomial, {-0.28, 0.10, 6e-4, -4e-4, -0.02}); }

 private:
  test::TemporaryFolder folder_;
};

TEST_F(CalibrateCommand, SolvesLensAndPlaneFromPicturesOfABoard) {
  const std::vector<PlanePose> poses = test::board_poses(spec(), 6, 32.0, 480.0);
  std::vector<std::string> arguments;
  for (std::size_t i = 0; i < poses.size(); ++i)
    arguments.push_back(board_file("v" + std::to_string(i) + ".png", poses[i]));
  const std::string plane = arguments[2];
  arguments.insert(arguments.end(), {"--board", "chessboard:9x6", "--pitch", "25", "--unit", "mm", "--plane", plane,
                                     "--overlay", file("overlay.png")});
  const test::Outcome outcome = calibrate(arguments);
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("lens         fx "), HasSubstr("covered      "), HasSubstr(plane)));
  const Calibration calibration = load_calibration(file("out.yaml"));
  EXPECT_EQ(calibration.unit, "mm");
  EXPECT_NEAR(calibration.lens->camera().fx, 800.0, 0.8);
  EXPECT_EQ(calibration.residuals.views.size(), 6U);
  const Eigen::Vector2d point(100.0, 50.0);
  EXPECT_LT(
      (mapping_of(calibration).image_from_plane(point) - Mapping::from_lens(lens(), poses[2]).image_from_plane(point))
          .norm(),
      0.02);
  const cv::Mat overlay = cv::imread(file("overlay.png"));
  ASSERT_FALSE(overlay.empty());
  // Green rings lie where the corners are.
  const Eigen::Vector2d corner = Mapping::from_lens(lens(), poses[2]).image_from_plane(Eigen::Vector2d(25.0, 25.0));
  int green = 0;
  for (int dy = -8; dy <= 8; ++dy) {
    for (int dx = -8; dx <= 8; ++dx) {
      const auto pixel =
          overlay.at<cv::Vec3b>(static_cast<int>(corner.y() * 2.0) + dy, static_cast<int>(corner.x() * 2.0) + dx);
      green += pixel[1] > pixel[0] + 80 && pixel[1] > pixel[2] + 80 ? 1 : 0;
    }
  }
  EXPECT_GT(green, 8);
}

TEST_F(CalibrateCommand, SolvesFromSingleFieldsForWholeFrames) {
  const PlanePose pose = test::board_poses(spec(), 1, 25.0, 480.0)[0];
  test::write_file(
      file("lens.yaml"),
      "image_width: 640\nimage_height: 480\ncamera_matrix: {data: [800, 0, 322.3, 0, 790, 236.1, 0, 0, 1]}\n"
      "distortion_coefficients: {data: [-0.28, 0.10, 6e-4, -4e-4, -0.02]}\n");
  const test::Outcome outcome = calibrate({board_file("top.png", pose, Field::top), "--board", "chessboard:9x6",
                                           "--pitch", "25", "--field", "top", "--import", file("lens.yaml")});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Calibration calibration = load_calibration(file("out.yaml"));
  EXPECT_EQ(calibration.made_from, Field::top);
  EXPECT_EQ(calibration.image_height, 480);
  const Eigen::Vector2d point(100.0, 50.0);
  EXPECT_LT((mapping_of(calibration).image_from_plane(point) - Mapping::from_lens(lens(), pose).image_from_plane(point))
                .norm(),
            0.02);
}

TEST_F(CalibrateCommand, SolvesFromPointPairs) {
  test::write_file(file("p.csv"),
                   "image_x,image_y,world_x,world_y\n10,20,0,0\n600,35,200,0\n620,455,200,150\n30,430,0,150\n");
  const test::Outcome outcome =
      calibrate({"--points", file("p.csv"), "--image-size", "640x480", "--unit", "cm", "--overlay", file("o.png")});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Calibration calibration = load_calibration(file("out.yaml"));
  EXPECT_EQ(calibration.unit, "cm");
  EXPECT_LT((mapping_of(calibration).plane_from_image({620, 455}) - Eigen::Vector2d(200, 150)).norm(), 1e-9);
  EXPECT_EQ(cv::imread(file("o.png")).size(), cv::Size(1280, 960));
}

TEST_F(CalibrateCommand, NamesOutliersOnStderrAndGoesOn) {
  std::string text = "image_x,image_y,world_x,world_y\n";
  for (int i = 0; i < 9; ++i) {
    const int x = i % 3, y = i / 3;
    text += std::to_string(100 + 200 * x + (i == 4 ? 30 : 0)) + "," + std::to_string(50 + 180 * y) + "," +
            std::to_string(10 * x) + "," + std::to_string(9 * y) + "\n";
  }
  test::write_file(file("p.csv"), text);
  const test::Outcome outcome = calibrate({"--points", file("p.csv"), "--image-size", "640x480"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr(file("p.csv") + ":6: lies 30.00 px from where the other points put it: left out"));
}

TEST_F(CalibrateCommand, TakesAPixelAspectAlone) {
  ASSERT_EQ(calibrate({"--pixel-aspect", "pal"}).code, 0);
  const Calibration calibration = load_calibration(file("out.yaml"));
  EXPECT_DOUBLE_EQ(calibration.pixel_aspect, 59.0 / 54.0);
  EXPECT_EQ(calibration.unit, "px");
  EXPECT_EQ(calibration.image_width, 0);
}

TEST_F(CalibrateCommand, RefusesInOneLine) {
  test::write_file(file("three.csv"), "image_x,image_y,world_x,world_y\n1,2,3,4\n5,6,7,8\n9,1,2,3\n");
  test::write_file(file("bad.yaml"), "camera_matrix: [0, 0, 0, 0, 0, 0, 0, 0, 1]\n");
  cv::imwrite(file("grey.png"), cv::Mat(480, 640, CV_8U, cv::Scalar(128)));
  cv::imwrite(file("small.png"), cv::Mat(240, 320, CV_8U, cv::Scalar(128)));
  expect_refused({}, 2, HasSubstr("what from? (allowed: pictures with --board, --points, --import, --pixel-aspect)"));
  expect_refused({"--board", "chess:9x6"}, 2, HasSubstr("--board board 'chess:9x6': not a known kind"));
  expect_refused({"--board", "chessboard:9x6", "--pitch", "25"}, 2, HasSubstr("pictures of the board are needed"));
  expect_refused({file("grey.png"), "--board", "chessboard:9x6"}, 2, HasSubstr("--pitch is needed"));
  expect_refused({file("grey.png"), "--board", "chessboard:9x6", "--pitch", "-1"}, 2,
                 HasSubstr("--pitch '-1' is out of range"));
  expect_refused({file("grey.png"), "--board", "chessboard:9x6", "--pitch", "25"}, 2,
                 HasSubstr("the board is not seen"));
  expect_refused({file("none.png"), "--board", "chessboard:9x6", "--pitch", "25"}, 3, HasSubstr("none.png"));
  expect_refused({file("grey.png"), "--board", "chessboard:9x6", "--pitch", "25", "--plane", "x.png"}, 2,
                 HasSubstr("none of the pictures"));
  expect_refused({"--points", file("three.csv")}, 2, HasSubstr("--image-size is needed"));
  expect_refused({"--points", file("three.csv"), "--image-size", "640"}, 2, HasSubstr("--image-size '640' is no size"));
  expect_refused({"--points", file("three.csv"), "--image-size", "640x480"}, 2,
                 HasSubstr("has 3 points, a plane needs at least four"));
  expect_refused({"--points", file("none.csv"), "--image-size", "640x480"}, 3, HasSubstr("none.csv: cannot be read"));
  expect_refused({"--points", file("three.csv"), "--image-size", "640x480", "--unit", "a,b"}, 2,
                 HasSubstr("--unit 'a,b' is no unit"));
  expect_refused({"--import", file("bad.yaml")}, 2, HasSubstr("bad.yaml:1: camera_matrix: its first number is 0"));
  expect_refused({"--import", file("none.yaml")}, 3, HasSubstr("none.yaml: cannot be read"));
  expect_refused({"--pixel-aspect", "11:1"}, 2, HasSubstr("--pixel-aspect"));
  expect_refused({"--pixel-aspect", "pal", "--unit", "mm"}, 2, HasSubstr("has the unit px"));
  expect_refused({"--pixel-aspect", "pal", "--overlay", file("o.png")}, 2, HasSubstr("no picture to draw over"));
  const test::Outcome unwritable = test::vsfind({"calibrate", "--pixel-aspect", "pal", "-o", file("no/out.yaml")});
  EXPECT_EQ(unwritable.code, 3);
  EXPECT_THAT(unwritable.err, HasSubstr("no/out.yaml: cannot be written"));
  EXPECT_THAT(test::vsfind({"calibrate", "--pixel-aspect", "pal"}).err, HasSubstr("--output is needed"));
}

TEST_F(CalibrateCommand, RefusesPicturesOfTwoSizesAndMovingBoards) {
  const PlanePose pose = test::board_poses(spec(), 1, 25.0, 480.0)[0];
  PlanePose moved = pose;
  moved.translation.x() += 5.0;
  const auto combed = test::woven_picture(spec(), Mapping::from_lens(lens(), pose), Mapping::from_lens(lens(), moved));
  cv::imwrite(file("combed.png"), cv::Mat(480, 640, CV_8U, const_cast<std::byte*>(combed.view().data)));
  cv::imwrite(file("small.png"), cv::Mat(240, 320, CV_8U, cv::Scalar(128)));
  const std::string good = board_file("good.png", pose);
  expect_refused({good, file("small.png"), "--board", "chessboard:9x6", "--pitch", "25"}, 2,
                 HasSubstr("small.png: is of 320x240, the others are of 640x480"));
  expect_refused({good, file("combed.png"), "--board", "chessboard:9x6", "--pitch", "25"}, 2,
                 HasSubstr("combed.png: the two fields of this interlaced picture see the board"));
}

}  // namespace
}  // namespace vsfind
