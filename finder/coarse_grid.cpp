#include "finder/coarse_grid.h"

#include <algorithm>
#include <cmath>

namespace vsfind {

std::vector<double> cell_centres(const Range& range, double step) {
  if (!range.searched() || step <= 0.0) return {(range.min + range.max) / 2.0};
  const int count = std::max(1, static_cast<int>(std::ceil(range.width() / step - 1e-9)));
  std::vector<double> centres;
  centres.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) centres.push_back(range.min + range.width() * (i + 0.5) / count);
  return centres;
}

namespace {

std::vector<double> scale_centres(const Range& range, double step) {
  // Equal ratios: a step at a large scale moves the points no further than one at a small scale, relative to them.
  std::vector<double> centres = cell_centres({std::log(range.min), std::log(range.max)}, std::log1p(step));
  for (double& centre : centres) centre = std::exp(centre);
  return centres;
}

}  // namespace

std::vector<Hypothesis> hypotheses(const CoarseGrid& grid) {
  Range angle = grid.angle_deg;
  if (angle.width() > 360.0) angle.max = angle.min + 360.0;
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
