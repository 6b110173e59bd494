/// How exact poses on the plane are, seen by cameras with pixels that are not square, at a slant, through a lens.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "app/qualify/pose_bound.h"
#include "calibrated_stage.h"
#include "rows.h"
#include "stage.h"

namespace vsfind::measure {
namespace {

struct Target {
  double most_px;    ///< largest error, pattern pixels
  double mean_px;    ///< of the distances
  double angle_deg;  ///< largest
};

bool row_of(const Settings& settings, const Camera& camera, Kind kind, double angle_limit, Field field,
            const Target& target) {
  Row row;
  row.name = fmt::format("{}, {}, {}", camera.name, name(kind), name(field));
  const render::Drawing drawing = drawing_of(kind);
  const Range angle{-angle_limit, angle_limit};
  // Trained at different places: near, in the middle, far.
  constexpr int trainings = 3;
  double sum = 0.0;
  double most = 0.0;
  double pitch = 1.0;
  PoseBoundEstimator all_pixels;
  for (int t = 0; t < trainings; ++t) {
    const Eigen::Vector2d at(320.0 + 90.0 * (t - 1), 240.0 + 100.0 * (t - 1));
    const CalibratedPattern trained =
        train_through(camera, drawing, at, angle, settings.seed * 10 + static_cast<std::uint64_t>(t), settings.noise);
    pitch = trained.pattern->pitch;
    Finder finder({trained.pattern}, {});
    CalibratedRecipe recipe;
    recipe.angle_limit = angle_limit;
    recipe.field = field;
    recipe.noise = settings.noise;
    for (int i = 0; i < (settings.scenes + trainings - 1) / trainings; ++i) {
      const auto seed = settings.seed * 100003 + static_cast<std::uint64_t>(1000 * t + i);
      const CalibratedShot shot = shot_through(camera, trained, recipe, seed);
      const auto& matches = finder.find(shot.picture.view(), shot.mapping)[0].matches;
      row.ms.push_back(finder.search_ms());
      ++row.scenes;
      ++row.expected;
      if (matches.empty()) {
        fmt::print("    not found: training {}, seed {}, truth {:.2f} {:.2f} {:.2f}\n", t, seed, shot.truth.x,
                   shot.truth.y, shot.truth.angle_deg);
        continue;
      }
      ++row.found;
      all_pixels.add(shot.picture.view(), shot.mapping, *trained.pattern, shot.truth, recipe.noise);
      const CalibratedError error = error_of(matches[0], shot, *trained.pattern);
      const double off = std::hypot(error.x, error.y);
      if (off > 0.5 || std::abs(error.angle_deg) > 0.3) {
        fmt::print("    wrong: training {}, seed {}, off by {:.2f} px, {:.2f} deg, score {:.3f}, at {:.1f} {:.1f}\n", t,
                   seed, off, error.angle_deg, matches[0].score, matches[0].frame_position.x(),
                   matches[0].frame_position.y());
        continue;
      }
      ++row.right;
      row.x.add(error.x);
      row.y.add(error.y);
      row.angle.add(error.angle_deg);
      row.scale_x.add(matches[0].pose.scale_x - shot.truth.scale_x);
      row.scale_y.add(matches[0].pose.scale_y - shot.truth.scale_y);
      row.ratio_x.add(error.x * trained.pattern->pitch / matches[0].sigma_x);
      row.ratio_y.add(error.y * trained.pattern->pitch / matches[0].sigma_y);
      row.ratio_angle.add(error.angle_deg / matches[0].sigma_angle_deg);
      sum += off;
      most = std::max(most, off);
    }
  }
  const double mean = row.right > 0 ? sum / row.right : 0.0;
  row.target = fmt::format("100%, max {:g} px, {:g} deg, mean {:g}", target.most_px, target.angle_deg, target.mean_px);
  row.ok = row.right == row.expected && most <= target.most_px && mean <= target.mean_px &&
           row.angle.max() <= target.angle_deg;
  const PoseBound bound = all_pixels.bound(true);
  row.extra = fmt::format(
      "distance max {:.4f} mean {:.4f}, error/sigma rms {:.2f} {:.2f} {:.2f}, bound {:.4f} {:.4f} px {:.4f} deg", most,
      mean, row.ratio_x.rms(), row.ratio_y.rms(), row.ratio_angle.rms(), bound.x / pitch, bound.y / pitch,
      bound.angle_deg);
  print(row);
  return row.ok;
}

Entry entry(const std::string& label, const Camera& camera, Kind kind, double angle_limit, const Target& target) {
  return {label, [camera, kind, angle_limit, target](const Settings& settings) {
            bool ok = true;
            for (const Field field : {Field::frame, Field::top, Field::bottom}) {
              ok = row_of(settings, camera, kind, angle_limit, field, target) && ok;
            }
            return ok;
          }};
}

}  // namespace

std::vector<Entry> calibrated_rows() {
  return {entry("calibrated aspect", pixel_aspect_camera(), Kind::artwork, 180.0, {0.01, 0.01, 0.01}),
          entry("calibrated slant", slanted_camera(), Kind::artwork, 60.0, {0.03, 0.01, 0.02}),
          entry("calibrated lens", slanted_lens_camera(), Kind::artwork, 60.0, {0.06, 0.02, 0.04}),
          // Small patterns and more perspective: whether they are found at all.
          entry("calibrated small", slanted_lens_camera(), Kind::small_artwork, 60.0, {0.5, 0.5, 0.3}),
          entry("calibrated steep", steep_camera(), Kind::small_artwork, 60.0, {0.5, 0.5, 0.3})};
}

}  // namespace vsfind::measure
