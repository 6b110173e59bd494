// Real photographs of chessboards: OpenCV's own, as Debian's opencv-doc installs them.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "acquisition/image_file.h"
#include "calibration/import.h"
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

TEST_P(Photos, FitAsWellAsOpenCvsOwnCalibration) {
  const std::vector<BoardView> views = views_of(GetParam());
  ASSERT_EQ(views.size(), 13U);
  const Solution solution = solve_views(views, options_640());
  const PinholeCamera& c = solution.calibration.lens->camera();
  const LensUncertainty& u = *solution.uncertainty;
  std::printf(
      "%s: rms %.4f px, worst %.3f, covered %.0f%%, fx %.2f +- %.2f fy %.2f +- %.2f cx %.2f +- %.2f cy %.2f +- %.2f\n",
      GetParam(), solution.calibration.residuals.rms, solution.calibration.residuals.worst, 100.0 * solution.covered,
      c.fx, u.fx, c.fy, u.fy, c.cx, u.cx, c.cy, u.cy);
  for (const auto& view : solution.calibration.residuals.views)
    std::printf("  %s %.3f %.3f\n", view.name.c_str(), view.rms, view.worst);
  for (const auto& w : solution.warnings) std::printf("  %s\n", w.c_str());
  EXPECT_LE(solution.calibration.residuals.rms, 0.20);
}
INSTANTIATE_TEST_SUITE_P(Sides, Photos, testing::Values("left", "right"));

}  // namespace
}  // namespace vsfind
