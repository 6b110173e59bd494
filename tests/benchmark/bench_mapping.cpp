/// What calibration costs: the same part and clutter searched in plain pixels, and on a slanted plane without and with
/// a lens; and the mapping of many points by itself.
#include <benchmark/benchmark.h>

#include <memory>
#include <numeric>
#include <vector>

#include "finder/calibrated_stage.h"
#include "finder/rectified_level.h"
#include "render/patterns.h"

namespace {

using namespace vsfind;

measure::Camera camera_of(int index) {
  if (index == 1) return measure::slanted_camera();
  if (index == 2) return measure::slanted_lens_camera();
  return {"plain", Mapping(), 1.0, "px"};
}

/// Arguments: 0 plain pixels, 1 perspective, 2 perspective and lens; degrees to either side. Eight scenes a turn.
void find_calibrated(benchmark::State& state) {
  const measure::Camera camera = camera_of(static_cast<int>(state.range(0)));
  const auto angle = static_cast<double>(state.range(1));
  const auto trained =
      measure::train_through(camera, render::artwork(3, 150.0, 130.0), {330.0, 250.0}, {-angle, angle}, 1);
  std::vector<measure::CalibratedShot> shots;
  measure::CalibratedRecipe recipe;
  recipe.angle_limit = angle;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) shots.push_back(shot_through(camera, trained, recipe, seed));
  Finder finder({trained.pattern}, {});
  for (auto step : state) {
    static_cast<void>(step);
    for (const auto& shot : shots) {
      if (finder.find(shot.picture.view(), shot.mapping)[0].matches.empty()) state.SkipWithError("not found");
    }
  }
  state.SetLabel(camera.name);
}
BENCHMARK(find_calibrated)->ArgsProduct({{0, 1, 2}, {10, 60}})->Unit(benchmark::kMillisecond);

/// 450 points through a pose: argument as above, 3 fisheye.
void map_points(benchmark::State& state) {
  const auto index = static_cast<int>(state.range(0));
  Mapping mapping = camera_of(index).mapping;
  if (index == 3) {
    const Lens lens(LensModel::fisheye, {1008.0, 1003.0, 322.4, 236.8}, std::vector<double>{-0.02, 0.01, 0.0, 0.0});
    mapping = Mapping::from_lens(lens, {Eigen::Matrix3d::Identity(), {0.0, 0.0, 500.0}});
  }
  constexpr std::size_t count = 450;
  std::vector<double> x(count);
  std::vector<double> y(count);
  std::vector<double> u(count);
  std::vector<double> v(count);
  for (std::size_t i = 0; i < count; ++i) {
    x[i] = static_cast<double>(i % 21) - 10.0;
    y[i] = static_cast<double>(i / 21) - 10.0;
  }
  for (auto step : state) {
    static_cast<void>(step);
    mapping.image_from_local({}, std::span<const double>(x), y, u, v);
    benchmark::DoNotOptimize(u.data());
    benchmark::DoNotOptimize(v.data());
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(count));
}
BENCHMARK(map_points)->DenseRange(0, 3);

/// A level of 80 × 60 seen straight on: argument 1 perspective, 2 perspective and lens.
void rectify_level(benchmark::State& state) {
  const Mapping mapping = camera_of(static_cast<int>(state.range(0))).mapping;
  const std::vector<std::uint8_t> memory(std::size_t{80} * 60, 128);
  const Level level{memory.data(), 80, 60, 80, 8.0, 8.0, 3.5, 3.5};
  RectifiedLevel rectified;
  for (auto step : state) {
    static_cast<void>(step);
    if (!rectified.update(level, mapping, 1000.0)) state.SkipWithError("not rectified");
  }
}
BENCHMARK(rectify_level)->Arg(1)->Arg(2)->Unit(benchmark::kMicrosecond);

}  // namespace

BENCHMARK_MAIN();
