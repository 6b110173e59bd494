// Real photographs of chessboards: OpenCV's own, as Debian's opencv-doc installs them.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "acquisition/image_file.h"
#include "calibration/solve.h"

namespace vsfind {
namespace {

const std::string folder = "/usr/share/doc/opencv-doc/examples/data/";

std::vector<BoardView> views_of(const std::string& side) {
  BoardSpec spec = parse_board("chessboard:9x6");
  spec.pitch = 25.0;
  std::vector<BoardView> views;
  for (int i = 1; i <= 14; ++i) {
    const std::string name = side + (i < 10 ? "0" : "") + std::to_string(i) + ".jpg";
    if (!std::filesystem::exists(folder + name)) continue;  // there is no number 10
    const Image image = load_image(folder + name);
    const auto view = find_board(image.view(), Field::frame, spec, name);
    EXPECT_TRUE(view.has_value()) << name;
    if (view) views.push_back(*view);
  }
  return views;
}

SolveOptions options_640() {
  SolveOptions options;
  options.image_width = 640;
  options.image_height = 480;
  return options;
}

class Photos : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(folder + "left01.jpg")) GTEST_SKIP() << "opencv-doc is not installed";
  }
};

// OpenCV's usual way: its older detector, its own sub-pixel refinement, its calibration.
struct UsualWay {
  double rms = 0.0;
  PinholeCamera camera;
  LensUncertainty uncertainty;
};

UsualWay usual_way(const std::string& side) {
  std::vector<std::vector<cv::Point3f>> object;
  std::vector<std::vector<cv::Point2f>> image;
  for (int i = 1; i <= 14; ++i) {
    const std::string path = folder + side + (i < 10 ? "0" : "") + std::to_string(i) + ".jpg";
    if (!std::filesystem::exists(path)) continue;
    const cv::Mat picture = cv::imread(path, cv::IMREAD_GRAYSCALE);
    std::vector<cv::Point2f> corners;
    EXPECT_TRUE(cv::findChessboardCorners(picture, {9, 6}, corners)) << path;
    cv::cornerSubPix(picture, corners, {11, 11}, {-1, -1}, {cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 30, 0.01});
    image.push_back(corners);
    object.emplace_back();
    for (int k = 0; k < 54; ++k)
      object.back().emplace_back(static_cast<float>(k % 9) * 25.0F, static_cast<float>(k / 9) * 25.0F, 0.0F);
  }
  cv::Mat camera, coefficients, deviations, pose_deviations, errors;
  std::vector<cv::Mat> rotations, translations;
  UsualWay way;
  way.rms = cv::calibrateCamera(object, image, {640, 480}, camera, coefficients, rotations, translations, deviations,
                                pose_deviations, errors);
  way.camera = {camera.at<double>(0, 0), camera.at<double>(1, 1), camera.at<double>(0, 2), camera.at<double>(1, 2)};
  way.uncertainty = {
      deviations.at<double>(0), deviations.at<double>(1), deviations.at<double>(2), deviations.at<double>(3), {}};
  return way;
}

TEST_P(Photos, FitAsWellAsInOpenCvsUsualWay) {
  const std::vector<BoardView> views = views_of(GetParam());
  ASSERT_EQ(views.size(), 13U);
  const Solution solution = solve_views(views, options_640());
  const UsualWay usual = usual_way(GetParam());
  const PinholeCamera& c = solution.calibration.lens->camera();
  const LensUncertainty& u = *solution.uncertainty;
  std::printf("%-6s rms %.4f px, fx %.2f +- %.2f, fy %.2f +- %.2f, cx %.2f +- %.2f, cy %.2f +- %.2f\n", GetParam(),
              solution.calibration.residuals.rms, c.fx, u.fx, c.fy, u.fy, c.cx, u.cx, c.cy, u.cy);
  std::printf("OpenCV rms %.4f px, fx %.2f +- %.2f, fy %.2f +- %.2f, cx %.2f +- %.2f, cy %.2f +- %.2f\n", usual.rms,
              usual.camera.fx, usual.uncertainty.fx, usual.camera.fy, usual.uncertainty.fy, usual.camera.cx,
              usual.uncertainty.cx, usual.camera.cy, usual.uncertainty.cy);
  EXPECT_LE(solution.calibration.residuals.rms, 0.20);
  EXPECT_LE(solution.calibration.residuals.rms, usual.rms);
  EXPECT_LE(u.fx, usual.uncertainty.fx);
  // Corners measured in two ways: both uncertainties count.
  const auto within = [](double a, double sigma_a, double b, double sigma_b) {
    return std::abs(a - b) <= 3.0 * std::hypot(sigma_a, sigma_b);
  };
  EXPECT_TRUE(within(c.fx, u.fx, usual.camera.fx, usual.uncertainty.fx));
  EXPECT_TRUE(within(c.fy, u.fy, usual.camera.fy, usual.uncertainty.fy));
  EXPECT_TRUE(within(c.cx, u.cx, usual.camera.cx, usual.uncertainty.cx));
  EXPECT_TRUE(within(c.cy, u.cy, usual.camera.cy, usual.uncertainty.cy));
}
INSTANTIATE_TEST_SUITE_P(Sides, Photos, testing::Values("left", "right"));

}  // namespace
}  // namespace vsfind
