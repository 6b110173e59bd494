#include "finder/pattern_points.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "finder/informative_points.h"

namespace vsfind {

namespace {

/// Points of a level's picture with their gradients, from the whole pattern.
std::vector<PatternPoint> level_points(TrainingScene& scene, int index) {
  const Level& level = scene.pyramid().smoothed(index);
  const double step = std::ldexp(1.0, index);
  const BilinearReader reader(level);
  const Projection projection = scene.projection(level);
  std::vector<PatternPoint> points;
  for (const Eigen::Vector2d& at : scene.lattice(step, step / 2.0 - 1e-6)) {
    const double x[5] = {at.x(), at.x() - step, at.x() + step, at.x(), at.x()};
    const double y[5] = {at.y(), at.y(), at.y(), at.y() - step, at.y() + step};
    double u[5], v[5], value[5], inside[5];
    projection.level_from_pattern(scene.pose(), x, y, 5, u, v);
    reader.read(u, v, 5, value, inside);
    if (*std::min_element(inside, inside + 5) == 0.0) continue;
    PatternPoint p;
    p.x = at.x();
    p.y = at.y();
    p.value = static_cast<float>(value[0]);
    p.gradient_x = static_cast<float>((value[2] - value[1]) / (2.0 * step));
    p.gradient_y = static_cast<float>((value[4] - value[3]) / (2.0 * step));
    points.push_back(p);
  }
  return points;
}

/// A point of full resolution read through the Gaussian that the search uses too.
bool read_fine(const TrainingScene& scene, const GaussianReader& reader, PatternPoint& p) {
  const Eigen::Vector2d plane(scene.pose().x + scene.pitch() * p.x, scene.pose().y + scene.pitch() * p.y);
  const Eigen::Vector2d image = scene.mapping().image_from_plane(plane);
  double read[4];
  if (!reader.read_with_derivatives(image.x(), image.y(), read)) return false;
  const Eigen::Matrix2d jacobian = scene.mapping().image_from_plane_jacobian(plane) * scene.pitch();
  p.value = static_cast<float>(read[0]);
  p.gradient_x = static_cast<float>(read[1] * jacobian(0, 0) + read[2] * jacobian(1, 0));
  p.gradient_y = static_cast<float>(read[1] * jacobian(0, 1) + read[2] * jacobian(1, 1));
  // Exact for square pixels; elsewhere near enough for what it is: a nuisance that takes up differences in sharpness.
  p.laplacian = static_cast<float>(read[3] * std::abs(jacobian.determinant()));
  return true;
}

std::vector<PatternPoint> pick(const std::vector<PatternPoint>& all, const std::vector<std::size_t>& chosen) {
  std::vector<PatternPoint> points;
  points.reserve(chosen.size());
  for (const std::size_t k : chosen) points.push_back(all[k]);
  return points;
}

/// Whether each point lies at the pattern's outermost edges, seen from its middle.
std::vector<char> on_outline(const std::vector<PatternPoint>& points) {
  constexpr double reach = 4.0;        // pattern pixels: an edge and the kernel's width
  constexpr double significant = 0.2;  // of the strongest gradients
  std::vector<float> strengths;
  Eigen::Vector2d middle(0.0, 0.0);
  for (const PatternPoint& p : points) {
    strengths.push_back(std::hypot(p.gradient_x, p.gradient_y));
    middle += Eigen::Vector2d(p.x, p.y) / static_cast<double>(points.size());
  }
  std::vector<float> sorted = strengths;
  const auto high = sorted.begin() + static_cast<std::ptrdiff_t>(static_cast<double>(sorted.size() - 1) * 0.99);
  std::nth_element(sorted.begin(), high, sorted.end());
  const float least = static_cast<float>(significant) * *high;
  constexpr int sectors = 360;
  const auto sector = [&](const PatternPoint& p) {
    const double turn = std::atan2(p.y - middle.y(), p.x - middle.x()) / (2.0 * std::numbers::pi) + 0.5;
    return static_cast<std::size_t>(std::clamp(static_cast<int>(turn * sectors), 0, sectors - 1));
  };
  const auto radius = [&](const PatternPoint& p) { return std::hypot(p.x - middle.x(), p.y - middle.y()); };
  std::vector<double> outermost(sectors, 0.0);
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (strengths[k] >= least) outermost[sector(points[k])] = std::max(outermost[sector(points[k])], radius(points[k]));
  }
  std::vector<char> outline(points.size(), 0);
  for (std::size_t k = 0; k < points.size(); ++k) {
    // A neighbouring sector may hold the edge where this one just misses it. Along a slanted ray an edge is deeper.
    const std::size_t s = sector(points[k]);
    const double edge = std::max({outermost[s], outermost[(s + 1) % sectors], outermost[(s + sectors - 1) % sectors]});
    const double g = std::max(1e-6, static_cast<double>(strengths[k]));
    const double slant = std::abs(static_cast<double>(points[k].gradient_x) * (points[k].x - middle.x()) +
                                  static_cast<double>(points[k].gradient_y) * (points[k].y - middle.y())) /
                         (g * std::max(1e-6, radius(points[k])));
    if (radius(points[k]) > edge - reach / std::max(0.5, slant)) outline[k] = 1;
  }
  return outline;
}

}  // namespace

Freedom freedom_of(const TrainOptions& options) {
  Freedom freedom;
  freedom.angle = options.angle_deg.searched();
  freedom.common_scale = options.common_scale && options.scale_x.searched();
  freedom.scale_x = options.scale_x.searched();
  freedom.scale_y = options.scale_y.searched();
  return freedom;
}

std::vector<PatternPoint> rough_points(TrainingScene& scene) {
  constexpr double border = 2.0;  // the kernel's reach: what lies around the pattern is not part of it
  const std::vector<Eigen::Vector2d> lattice = scene.lattice(1.0, border);
  if (lattice.empty()) return {};
  Eigen::Vector2d least = lattice.front();
  Eigen::Vector2d most = lattice.front();
  for (const Eigen::Vector2d& at : lattice) {
    least = least.cwiseMin(at);
    most = most.cwiseMax(at);
  }
  // One reading per pixel, one pixel more all around.
  const auto columns = static_cast<std::size_t>(std::lround(most.x() - least.x())) + 3;
  const auto rows = static_cast<std::size_t>(std::lround(most.y() - least.y())) + 3;
  const std::size_t n = columns * rows;
  std::vector<double> x(n), y(n), u(n), v(n), value(n), inside(n);
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t row = k / columns;
    x[k] = least.x() - 1.0 + static_cast<double>(k % columns);
    y[k] = least.y() - 1.0 + static_cast<double>(row);
  }
  scene.projection(scene.pyramid().level(0))
      .level_from_pattern(scene.pose(), x.data(), y.data(), static_cast<int>(n), u.data(), v.data());
  scene.gaussian().read(u.data(), v.data(), static_cast<int>(n), value.data(), inside.data());
  std::vector<PatternPoint> points;
  for (const Eigen::Vector2d& at : lattice) {
    const std::size_t k = (static_cast<std::size_t>(std::lround(at.y() - least.y())) + 1) * columns +
                          static_cast<std::size_t>(std::lround(at.x() - least.x())) + 1;
    if (inside[k] * inside[k - 1] * inside[k + 1] * inside[k - columns] * inside[k + columns] == 0.0) continue;
    PatternPoint p;
    p.x = at.x();
    p.y = at.y();
    p.value = static_cast<float>(value[k]);
    p.gradient_x = static_cast<float>((value[k + 1] - value[k - 1]) / 2.0);
    p.gradient_y = static_cast<float>((value[k + columns] - value[k - columns]) / 2.0);
    p.laplacian =
        static_cast<float>(value[k - 1] + value[k + 1] + value[k - columns] + value[k + columns] - 4.0 * value[k]);
    points.push_back(p);
  }
  return points;
}

std::vector<PointSet> refine_points(TrainingScene& scene, const TrainOptions& options,
                                    const std::vector<PatternPoint>& all) {
  if (all.empty()) return {};
  const std::vector<char> outer = on_outline(all);
  std::vector<PatternPoint> inner_candidates;
  std::vector<PatternPoint> outer_candidates;
  for (std::size_t k = 0; k < all.size(); ++k) (outer[k] != 0 ? outer_candidates : inner_candidates).push_back(all[k]);
  // 15 points per step of accuracy: 30 gives the 450 points that come near the bound of all pixels.
  const auto count = static_cast<std::size_t>(std::lround(10.0 + 15.0 * options.accuracy));
  constexpr double spacing = 2.0;  // nearer ones read the same pixels and tell nothing new
  // Gain, offset and sharpness count among what the points must settle: points on one flank of the edges only would
  // take a difference in any of them for a shift.
  Freedom freedom = freedom_of(options);
  freedom.blur = true;
  const auto choose = [&](const std::vector<PatternPoint>& candidates, std::size_t number, PointUse use) {
    PointSet set{0, use, pick(candidates, choose_informative(candidates, freedom, number, spacing, options.spread))};
    std::erase_if(set.points, [&](PatternPoint& p) { return !read_fine(scene, scene.gaussian(), p); });
    return set;
  };
  const auto strength = [](const std::vector<PatternPoint>& points) {
    double sum = 0.0;
    for (const PatternPoint& p : points) {
      sum += static_cast<double>(p.gradient_x) * static_cast<double>(p.gradient_x) +
             static_cast<double>(p.gradient_y) * static_cast<double>(p.gradient_y);
    }
    return sum;
  };
  // A pattern that is all outline has nothing else to trust.
  constexpr double least_inner_part = 0.15;
  if (strength(inner_candidates) < least_inner_part * strength(all)) return {choose(all, count, PointUse::refine)};
  // Turning and growing are seen best at the outline; where the pattern only moves it gets no more than its share.
  std::size_t outline = count * 2 / 5;
  if (!freedom.angle && !freedom.scale_x && !freedom.scale_y && !freedom.common_scale) {
    const double part = strength(outer_candidates) / strength(all);
    outline = std::min(outline, static_cast<std::size_t>(std::lround(part * static_cast<double>(count))));
  }
  return {choose(inner_candidates, count - outline, PointUse::refine),
          choose(outer_candidates, outline, PointUse::outline)};
}

PointSet verify_points(const TrainingScene& scene) {
  constexpr double wanted = 600.0;
  PointSet set{0, PointUse::verify, {}};
  const GaussianReader reader = scene.gaussian();
  const double step = std::max(1.0, std::sqrt(scene.width() * scene.height() / wanted));
  for (const Eigen::Vector2d& at : scene.lattice(step, 0.0)) {
    PatternPoint p;
    p.x = at.x();
    p.y = at.y();
    if (read_fine(scene, reader, p)) set.points.push_back(p);
  }
  return set;
}

PointSet follow_points(TrainingScene& scene, const TrainOptions& options, int level) {
  constexpr std::size_t count = 128;
  const std::vector<PatternPoint> all = level_points(scene, level);
  // Spread, so that hidden parts leave enough; the rest of the choice is by information.
  return {level, PointUse::follow,
          pick(all, choose_informative(all, freedom_of(options), count, std::ldexp(1.0, level) * 0.9, true))};
}

}  // namespace vsfind
