#include "finder/coarse_grid.h"

#include <algorithm>
#include <cmath>

namespace vsfind {

namespace {

double cell_count(const Range& range, double step) {
  if (!range.searched() || step <= 0.0) return 1.0;
  return std::max(1.0, std::ceil(range.width() / step - 1e-9));
}

}  // namespace

std::vector<double> cell_centres(const Range& range, double step) {
  if (!range.searched() || step <= 0.0) return {(range.min + range.max) / 2.0};
  const int count = static_cast<int>(cell_count(range, step));
  std::vector<double> centres;
  centres.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) centres.push_back(range.min + range.width() * (i + 0.5) / count);
  return centres;
}

namespace {

/// Equal ratios: a step at a large scale moves the points no further than one at a small scale, relative to them.
Range ratios(const Range& range) { return {std::log(range.min), std::log(range.max)}; }

/// A range of a full circle or more is covered once round.
Range once_round(Range angle) {
  if (angle.width() > 360.0) angle.max = angle.min + 360.0;
  return angle;
}

std::vector<double> scale_centres(const Range& range, double step) {
  std::vector<double> centres = cell_centres(ratios(range), std::log1p(step));
  for (double& centre : centres) centre = std::exp(centre);
  return centres;
}

}  // namespace

GridSize size_of(const CoarseGrid& grid) {
  const double scale_step = std::log1p(grid.scale_step);
  return {cell_count(once_round(grid.angle_deg), grid.angle_step_deg), cell_count(ratios(grid.scale_x), scale_step),
          grid.common_scale ? 1.0 : cell_count(ratios(grid.scale_y), scale_step)};
}

std::vector<Hypothesis> hypotheses(const CoarseGrid& grid) {
  const Range angle = once_round(grid.angle_deg);
  std::vector<Hypothesis> all;
  for (const double sx : scale_centres(grid.scale_x, grid.scale_step)) {
    const std::vector<double> sys =
        grid.common_scale ? std::vector<double>{sx} : scale_centres(grid.scale_y, grid.scale_step);
    for (const double sy : sys) {
      for (const double a : cell_centres(angle, grid.angle_step_deg)) all.push_back({a, sx, sy});
    }
  }
  return all;
}

}  // namespace vsfind
