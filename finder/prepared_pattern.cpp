#include "finder/prepared_pattern.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "acquisition/errors.h"
#include "finder/informative_points.h"
#include "finder/training_scene.h"

namespace vsfind {

namespace {

Range narrowed(const char* key, const std::optional<Range>& asked, const Range& trained) {
  if (!asked) return trained;
  constexpr double rounding = 1e-9;
  if (!(asked->min <= asked->max) || asked->min < trained.min - rounding || asked->max > trained.max + rounding) {
    throw UsageError(fmt::format("{} {}:{} is not within what the pattern was trained for (allowed: within {}:{})", key,
                                 asked->min, asked->max, trained.min, trained.max));
  }
  return *asked;
}

/// Second derivatives of the pattern as the points' Gaussian reads it, by differences between neighbours.
void add_bends(const PatternImage& image, std::vector<PatternPoint>& points) {
  constexpr int bits = 16;
  const ImageView view{reinterpret_cast<const std::byte*>(image.grey.data()), image.width, image.height,
                       static_cast<std::ptrdiff_t>(sizeof(std::uint16_t)) * image.width, bits};
  const GaussianReader reader(view, reading_sigma, reading_sigma);
  constexpr double step = 0.5;
  for (PatternPoint& point : points) {
    double u[9], v[9], value[9], inside[9];
    for (int i = 0; i < 9; ++i) {
      const int row = i / 3;
      u[i] = point.x + image.origin_x + step * (i - 3 * row - 1);
      v[i] = point.y + image.origin_y + step * (row - 1);
    }
    reader.read(u, v, 9, value, inside);
    if (*std::min_element(inside, inside + 9) == 0.0) continue;
    const double xx = value[3] + value[5] - 2.0 * value[4];
    const double yy = value[1] + value[7] - 2.0 * value[4];
    const double xy = 0.25 * (value[0] + value[8] - value[2] - value[6]);
    point.stretch = static_cast<float>((xx - yy) / (step * step));
    point.shear = static_cast<float>(2.0 * xy / (step * step));
  }
}

}  // namespace

PreparedPattern::PreparedPattern(std::shared_ptr<const Pattern> source, const SearchOptions& options)
    : pattern(std::move(source)) {
  const Pattern& p = *pattern;
  angle_deg = narrowed("angle", options.angle_deg, p.angle_deg);
  scale_x = narrowed("scale_x", options.scale_x, p.scale_x);
  scale_y = narrowed("scale_y", options.scale_y, p.scale_y);
  freedom.angle = angle_deg.searched();
  freedom.common_scale = p.common_scale && scale_x.searched();
  freedom.scale_x = scale_x.searched();
  freedom.scale_y = scale_y.searched();
  follow.resize(static_cast<std::size_t>(p.top_level) + 1);
  std::vector<PatternPoint> fine;
  for (const PointSet& set : p.sets) {
    switch (set.use) {
      case PointUse::search:
        search = CoarsePoints(set.points);
        climb = PointArrays(set.points);
        break;
      case PointUse::follow:
        if (set.level <= p.top_level) follow[static_cast<std::size_t>(set.level)] = PointArrays(set.points);
        break;
      case PointUse::refine:
        fine.insert(fine.begin(), set.points.begin(), set.points.end());
        trusted = static_cast<int>(set.points.size());
        break;
      case PointUse::outline:
        fine.insert(fine.end(), set.points.begin(), set.points.end());
        break;
      case PointUse::verify:
        verify = PointArrays(set.points);
        if (!p.image.grey.empty()) {
          std::vector<PatternPoint> bent = set.points;
          add_bends(p.image, bent);
          verify = PointArrays(bent);
        }
        break;
    }
  }
  if (!p.image.grey.empty()) add_bends(p.image, fine);
  refine = PointArrays(fine);
  // On their slopes these points vary less than the pattern does, which is what disagreement is measured by.
  if (verify.count > 0) refine.contrast = std::max(refine.contrast, verify.contrast);
  spline = PatternSpline(p.image);
  Freedom unshaded = fine_freedom();
  unshaded.shading = false;
  inflation = inflation_of(fine, unshaded);
  CoarseGrid grid{angle_deg, scale_x, scale_y, p.common_scale, p.angle_step_deg, p.scale_step};
  hypotheses = vsfind::hypotheses(grid);
}

Freedom PreparedPattern::fine_freedom() const {
  Freedom fine = freedom;
  fine.blur = true;
  fine.shading = true;
  return fine;
}

bool PreparedPattern::in_range(const Pose& pose) const {
  const Pattern& p = *pattern;
  if (freedom.angle && angle_deg.width() < 360.0) {
    const double slack = std::min(2.0, p.angle_step_deg / 2.0);
    const double middle = (angle_deg.min + angle_deg.max) / 2.0;
    if (angle_between(pose.angle_deg, middle) > angle_deg.width() / 2.0 + slack) return false;
  }
  const double slack = 1.0 + std::min(0.05, p.scale_step / 2.0);
  const auto within = [&](double scale, const Range& range) {
    return !range.searched() || (scale > range.min / slack && scale < range.max * slack);
  };
  return within(pose.scale_x, scale_x) && within(pose.scale_y, scale_y);
}

Polygon PreparedPattern::outline(const Pose& pose) const {
  const Pattern& p = *pattern;
  Polygon corners;
  for (const auto& [x, y] : {std::pair(p.left, p.top), std::pair(p.left + p.width, p.top),
                             std::pair(p.left + p.width, p.top + p.height), std::pair(p.left, p.top + p.height)}) {
    corners.add(plane_from_pattern(pose, Eigen::Vector2d(x, y) * p.pitch));
  }
  return corners;
}

}  // namespace vsfind
