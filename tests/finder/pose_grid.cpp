/// Searches pictures at very many random poses and tells how many were missed: a hole between the coarse search's steps
/// would show. Takes minutes, so it is run by hand; exits with 1 where one was missed.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>

#include "app/render/patterns.h"
#include "app/render/random.h"
#include "app/render/sensor.h"
#include "app/render/truth.h"
#include "finder/search.h"
#include "finder/train.h"

namespace {

using namespace vsfind;

struct Kind {
  const char* name;
  render::Drawing drawing;
  double angle;  ///< degrees to either side that are trained
  Range scale;
};

render::Picture picture_of(const render::Drawing& drawing, const Pose& pose, double noise, std::uint64_t seed) {
  render::Scene scene;
  scene.width = 240;
  scene.height = 200;
  scene.items.push_back({drawing, pose});
  render::Sensor sensor;
  sensor.noise = noise;
  sensor.seed = seed;
  return render::develop(render::expose(scene, 0.7, Field::frame, 4), sensor);
}

/// How many of the poses were missed.
int missed_of(const Kind& kind, int poses, double noise, std::uint64_t seed) {
  const Pose trained{119.7, 99.2, 0.0, 1.0, 1.0};
  TrainOptions options;
  options.roi.width = static_cast<int>(std::lround(kind.drawing.width));
  options.roi.height = static_cast<int>(std::lround(kind.drawing.height));
  options.roi.x = (240 - options.roi.width) / 2;
  options.roi.y = (200 - options.roi.height) / 2;
  options.angle_deg = {-kind.angle, kind.angle};
  options.scale_x = options.scale_y = kind.scale;
  options.common_scale = kind.scale.searched();
  const auto pattern =
      std::make_shared<const Pattern>(train(picture_of(kind.drawing, trained, noise, seed).view(), Mapping(), options));
  Finder finder({pattern}, {});
  render::Random random(seed);
  int missed = 0;
  double worst = 0.0;
  for (int i = 0; i < poses; ++i) {
    const double scale = random.uniform(kind.scale.min, kind.scale.max);
    const Pose pose{random.uniform(108.0, 132.0), random.uniform(88.0, 112.0), random.uniform(-kind.angle, kind.angle),
                    scale, scale};
    const Pose truth = render::expected_pose(trained, pose, render::roi_centre(options.roi));
    const render::Picture picture = picture_of(kind.drawing, pose, noise, random.bits());
    const auto& matches = finder.find(picture.view(), Mapping()).front().matches;
    const double error = matches.empty() ? 1e9 : std::hypot(matches[0].pose.x - truth.x, matches[0].pose.y - truth.y);
    if (error > 0.5 || std::abs(render::angle_difference_deg(matches[0].pose.angle_deg, truth.angle_deg)) > 0.5) {
      ++missed;
      fmt::print("{}: missed at x {:.3f} y {:.3f} angle {:.3f} scale {:.4f}{}\n", kind.name, pose.x, pose.y,
                 pose.angle_deg, scale, matches.empty() ? "" : " (found elsewhere)");
    } else {
      worst = std::max(worst, error);
    }
  }
  fmt::print("{}: {} poses, {} missed, worst error {:.4f} px\n", kind.name, poses, missed, worst);
  return missed;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Searches at random poses over all that was trained for, and tells how many were missed.");
  int poses = 20000;
  double noise = 2.0;
  std::uint64_t seed = 1;
  app.add_option("--poses", poses, "poses in all (default 20000)")->check(CLI::Range(4, 10000000));
  app.add_option("--noise", noise, "grey levels (default 2)")->check(CLI::Range(0.0, 50.0));
  app.add_option("--seed", seed, "seed (default 1)");
  CLI11_PARSE(app, argc, argv);
  const std::vector<Kind> kinds{
      {"bullseye, +-45 degrees", render::bullseye(96.0, 10.0), 44.0, {1.0, 1.0}},
      {"artwork, full circle", render::artwork(5, 90.0, 78.0), 180.0, {1.0, 1.0}},
      {"artwork, +-30 degrees, scales 0.85 to 1.15", render::artwork(3, 90.0, 78.0), 30.0, {0.85, 1.15}},
      {"wafer mark, +-10 degrees", render::wafer_mark(90.0), 10.0, {1.0, 1.0}}};
  int missed = 0;
  for (const Kind& kind : kinds) missed += missed_of(kind, poses / static_cast<int>(kinds.size()), noise, seed++);
  return missed == 0 ? 0 : 1;
}
