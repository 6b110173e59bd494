/// What calibration costs: the same part and clutter searched in plain pixels, and on a slanted plane without and with
/// a lens; and the mapping of many points by itself.
#include <benchmark/benchmark.h>

#include <Eigen/Geometry>
#include <map>
#include <utility>
#include <vector>

#include "app/render/patterns.h"
#include "finder/calibrated_stage.h"
#include "finder/rectified_level.h"

namespace {

using namespace vsfind;

measure::Camera camera_of(int index) {
  if (index == 1) return measure::slanted_camera();
  if (index == 2) return measure::slanted_lens_camera();
  if (index == 0) return {"plain", Mapping(), 1.0, "px"};
  // The plain picture again, to a thousandth of a pixel, with all the arithmetic of perspective and lens.
  const Lens lens(LensModel::polynomial, {900.0, 900.0, 320.0, 240.0},
                  std::vector<double>{1e-6, 1e-6, 1e-7, 1e-7, 1e-6});
  PlanePose plane;
  plane.rotation = Eigen::AngleAxisd(1e-6, Eigen::Vector3d::UnitX()).toRotationMatrix();
  plane.translation = {-320.0, -240.0, 900.0};
  return {"plain through a lens", Mapping::from_lens(lens, plane), 1.0, "px"};
}

struct Prepared {
  measure::CalibratedPattern trained;
  std::vector<measure::CalibratedShot> shots;
};

/// Rendered once, however often the benchmark is begun anew.
const Prepared& prepared(int camera_index, int angle) {
  static std::map<std::pair<int, int>, Prepared> all;
  const auto [at, fresh] = all.try_emplace({camera_index, angle});
  Prepared& made = at->second;
  if (!fresh) return made;
  const measure::Camera camera = camera_of(camera_index);
  const Range range{-1.0 * angle, 1.0 * angle};
  made.trained = measure::train_through(camera, render::artwork(3, 150.0, 130.0), {330.0, 250.0}, range, 1);
  measure::CalibratedRecipe recipe;
  recipe.angle_limit = angle;
  for (std::uint64_t seed = 1; seed <= 6; ++seed)
    made.shots.push_back(shot_through(camera, made.trained, recipe, seed));
  return made;
}

/// Arguments: 0 plain pixels, 1 perspective, 2 perspective and lens, 3 the scenes of 0 with the arithmetic of 2;
/// degrees to either side. Six scenes a turn.
void find_calibrated(benchmark::State& state) {
  const auto index = static_cast<int>(state.range(0));
  const Prepared& made = prepared(index, static_cast<int>(state.range(1)));
  Finder finder({made.trained.pattern}, {});
  for (auto step : state) {
    static_cast<void>(step);
    for (const auto& shot : made.shots) {
      if (finder.find(shot.picture.view(), shot.mapping)[0].matches.empty()) state.SkipWithError("not found");
    }
  }
  state.SetLabel(camera_of(index).name);
}
BENCHMARK(find_calibrated)->ArgsProduct({{0, 3, 1, 2}, {10, 60}})->Unit(benchmark::kMillisecond);

/// 450 points through a pose: 0 plain pixels, 1 perspective, 2 perspective and lens, 3 fisheye.
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
