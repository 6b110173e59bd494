/// The paper's scene (640 × 480, a square bullseye of 191 × 191, noise 2, blur 0.7): training, and the search against
/// OpenCV's matchTemplate in the same run. matchTemplate looks for the position alone; the search for angles as well.
#include <benchmark/benchmark.h>

#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "app/render/patterns.h"
#include "app/render/sensor.h"
#include "finder/search.h"
#include "finder/train.h"

namespace {

using namespace vsfind;

constexpr Roi roi{224, 144, 191, 191};

render::Picture sheet_with(const Pose& pose, std::uint64_t seed) {
  render::Scene scene = render::target_sheet();
  scene.items.push_back({render::bullseye(), pose});
  render::Sensor sensor;
  sensor.seed = seed;
  return render::develop(render::expose(scene, 0.7), sensor);
}

const render::Picture& training_picture() {
  static const render::Picture picture = sheet_with({319.2, 239.3, 0.0, 1.0, 1.0}, 1);
  return picture;
}

const render::Picture& turned_picture() {
  static const render::Picture picture = sheet_with({330.7, 228.4, 7.3, 1.0, 1.0}, 2);
  return picture;
}

TrainOptions options_for(double angle) {
  TrainOptions options;
  options.roi = roi;
  options.angle_deg = {-angle, angle};
  return options;
}

void train_paper_pattern(benchmark::State& state) {
  for (auto step : state) {
    static_cast<void>(step);
    benchmark::DoNotOptimize(train(training_picture().view(), Mapping(), options_for(45.0)));
  }
}
BENCHMARK(train_paper_pattern)->Unit(benchmark::kMillisecond);

/// Argument: degrees to either side.
void find_paper_pattern(benchmark::State& state) {
  const auto angle = static_cast<double>(state.range(0));
  const auto pattern = std::make_shared<const Pattern>(train(training_picture().view(), Mapping(), options_for(angle)));
  Finder finder({pattern}, {});
  const render::Picture& picture = angle > 0.0 ? turned_picture() : training_picture();
  for (auto step : state) {
    static_cast<void>(step);
    if (finder.find(picture.view(), Mapping())[0].matches.empty()) state.SkipWithError("not found");
  }
}
BENCHMARK(find_paper_pattern)->Arg(0)->Arg(45)->Arg(180)->Unit(benchmark::kMillisecond);

void opencv_match_template(benchmark::State& state) {
  cv::setNumThreads(1);
  const auto mat = [](const ImageView& view) {
    return cv::Mat(view.height, view.width, CV_8U, const_cast<std::byte*>(view.data), static_cast<size_t>(view.stride));
  };
  const cv::Mat image = mat(turned_picture().view());
  const cv::Mat pattern = mat(training_picture().view())(cv::Rect(roi.x, roi.y, roi.width, roi.height));
  cv::Mat scores;
  for (auto step : state) {
    static_cast<void>(step);
    cv::matchTemplate(image, pattern, scores, cv::TM_CCOEFF_NORMED);
    double best = 0.0;
    cv::minMaxLoc(scores, nullptr, &best);
    benchmark::DoNotOptimize(best);
  }
}
BENCHMARK(opencv_match_template)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
