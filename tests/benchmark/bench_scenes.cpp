/// What the time of a search depends on: the size of the picture, what else lies in it, how many instances there are,
/// scales searched besides the angle. Artwork without symmetry, found anew in every picture.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "app/render/clutter.h"
#include "app/render/patterns.h"
#include "app/render/sensor.h"
#include "finder/search.h"
#include "finder/train.h"

namespace {

using namespace vsfind;

render::Drawing part(double size) { return render::artwork(1, size, size * 13.0 / 15.0); }

struct Layout {
  int width = 640;
  int height = 480;
  double size = 150.0;  ///< of the part, pixels
  int instances = 1;
  int clutter = 0;
  double limit = 45.0;  ///< degrees to either side
  double quiet = -1.0;  ///< a part's own ground around it, pixels; negative: the clutter goes on under the part
};

/// Instances in a regular grid, each turned otherwise, over clutter all around.
render::Picture picture_of(const Layout& layout) {
  render::Scene scene;
  scene.width = layout.width;
  scene.height = layout.height;
  render::Random random(7);
  render::Clutter clutter;
  clutter.count = layout.clutter;
  clutter.decoys = 0.1;
  clutter.largest = 0.6 * layout.size;
  render::add_clutter(scene, random, clutter);
  const auto columns = std::max(1, static_cast<int>(std::ceil(std::sqrt(layout.instances))));
  const int rows = (layout.instances + columns - 1) / columns;
  for (int i = 0; i < layout.instances; ++i) {
    render::Item item{part(layout.size), {}};
    item.pose.x = layout.width * (i % columns + 0.5) / columns + 0.3;
    item.pose.y = layout.height * (i / columns + 0.5) / rows - 0.2;
    item.pose.angle_deg = std::remainder(17.0 + 47.0 * i, 2.0 * (layout.limit - 2.0));
    if (layout.quiet >= 0.0) {
      const double w = item.drawing.width / 2.0 + layout.quiet;
      const double h = item.drawing.height / 2.0 + layout.quiet;
      scene.items.push_back({{{{{render::rectangle(-w, -h, w, h)}, scene.background}}, 2 * w, 2 * h}, item.pose});
    }
    scene.items.push_back(item);
  }
  render::Sensor sensor;
  sensor.seed = 3;
  return render::develop(render::expose(scene, 0.7), sensor);
}

/// The part alone, upright, in the middle.
render::Picture training_picture(double size) {
  render::Scene scene;
  scene.width = static_cast<int>(1.6 * size);
  scene.height = scene.width;
  scene.items.push_back({part(size), {(scene.width - 1) / 2.0, (scene.height - 1) / 2.0, 0.0, 1.0, 1.0}});
  render::Sensor sensor;
  sensor.seed = 4;
  return render::develop(render::expose(scene, 0.7), sensor);
}

Roi roi_of(double size) {
  const auto width = static_cast<int>(size);
  const auto height = static_cast<int>(size * 13.0 / 15.0);
  const auto whole = static_cast<int>(1.6 * size);
  return {(whole - width) / 2, (whole - height) / 2, width, height};
}

void search(benchmark::State& state, const Layout& layout, const Range& scale) {
  const render::Picture training = training_picture(layout.size);
  TrainOptions options;
  options.roi = roi_of(layout.size);
  options.angle_deg = {-layout.limit, layout.limit};
  options.scale_x = options.scale_y = scale;
  const auto pattern = std::make_shared<const Pattern>(train(training.view(), Mapping(), options));
  SearchOptions wanted;
  wanted.max_instances = std::max(1, layout.instances);
  Finder finder({pattern}, wanted);
  const render::Picture picture = picture_of(layout);
  for (auto step : state) {
    static_cast<void>(step);
    const auto found = finder.find(picture.view(), Mapping())[0].matches.size();
    if (found != static_cast<std::size_t>(layout.instances)) state.SkipWithError("not found");
  }
}

void match_template(benchmark::State& state, const Layout& layout) {
  cv::setNumThreads(1);
  const auto mat = [](const ImageView& view) {
    return cv::Mat(view.height, view.width, CV_8U, const_cast<std::byte*>(view.data), static_cast<size_t>(view.stride));
  };
  const render::Picture picture = picture_of(layout);
  const render::Picture training = training_picture(layout.size);
  const Roi roi = roi_of(layout.size);
  const cv::Mat pattern = mat(training.view())(cv::Rect(roi.x, roi.y, roi.width, roi.height));
  cv::Mat scores;
  for (auto step : state) {
    static_cast<void>(step);
    cv::matchTemplate(mat(picture.view()), pattern, scores, cv::TM_CCOEFF_NORMED);
    double best = 0.0;
    cv::minMaxLoc(scores, nullptr, &best);
    benchmark::DoNotOptimize(best);
  }
}

constexpr Range no_scale{1.0, 1.0};
const Layout plain;
const Layout crowded{640, 480, 150.0, 1, 120, 45.0, 10.0};
const Layout crowded_under{640, 480, 150.0, 1, 120, 45.0};
const Layout without{640, 480, 150.0, 0, 25, 45.0};
const Layout large{2448, 2048, 250.0, 1, 150, 180.0};
const Layout large_eight{2448, 2048, 250.0, 8, 150, 180.0};
const Layout scaled{640, 480, 150.0, 1, 25, 45.0};

BENCHMARK_CAPTURE(search, empty_background, plain, no_scale)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(search, dense_clutter, crowded, no_scale)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(search, dense_clutter_under_the_part, crowded_under, no_scale)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(search, the_part_is_not_there, without, no_scale)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(search, both_scales, scaled, Range{0.8, 1.2})->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(match_template, 640x480, scaled)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(search, 2448x2048_full_circle, large, no_scale)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(search, 2448x2048_eight_instances, large_eight, no_scale)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(match_template, 2448x2048, large)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
