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

/// Σ over pairs of points of j·jᵀ·ρ, where the noise of two readings at distance d through the same Gaussian has the
/// correlation ρ = exp(−d²/4σ²).
Eigen::Matrix<double, 5, 1> inflation_of(const std::vector<PatternPoint>& points, const Freedom& freedom) {
  Eigen::Matrix<double, 5, 1> inflation = Eigen::Matrix<double, 5, 1>::Ones();
  if (points.empty()) return inflation;
  const Eigen::Index p = pose_derivatives(points[0], freedom).size();
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(p, p);
  Eigen::MatrixXd with_neighbours = Eigen::MatrixXd::Zero(p, p);
  std::vector<Eigen::VectorXd> j;
  for (const PatternPoint& point : points) j.push_back(pose_derivatives(point, freedom));
  constexpr double reach = 5.0;  // pattern pixels; beyond, the correlation is below 0.002
  for (std::size_t a = 0; a < points.size(); ++a) {
    information += j[a] * j[a].transpose();
    Eigen::VectorXd around = Eigen::VectorXd::Zero(p);
    for (std::size_t b = 0; b < points.size(); ++b) {
      const double dx = points[a].x - points[b].x;
      const double dy = points[a].y - points[b].y;
      if (std::abs(dx) > reach || std::abs(dy) > reach) continue;
      around += j[b] * std::exp(-(dx * dx + dy * dy) / (4.0 * reading_sigma * reading_sigma));
    }
    with_neighbours += j[a] * around.transpose();
  }
  information.diagonal().array() *= 1.0 + 1e-9;
  const Eigen::MatrixXd inverse = information.inverse();
  const Eigen::MatrixXd enlarged = inverse * with_neighbours * inverse;
  Eigen::Index k = 0;
  const auto ratio = [&](Eigen::Index at) {
    const double r = enlarged(at, at) / inverse(at, at);
    return std::isfinite(r) && r > 0.0 ? r : 1.0;
  };
  inflation(0) = ratio(k++);
  inflation(1) = ratio(k++);
  if (freedom.angle) inflation(2) = ratio(k++);
  if (freedom.common_scale) {
    inflation(3) = inflation(4) = ratio(k++);
  } else {
    if (freedom.scale_x) inflation(3) = ratio(k++);
    if (freedom.scale_y) inflation(4) = ratio(k++);
  }
  return inflation;
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
        break;
    }
  }
  refine = PointArrays(fine);
  Freedom unshaded = fine_freedom();
  unshaded.shading = false;
  inflation = inflation_of(fine, unshaded);
  double sum = 0.0;
  double squares = 0.0;
  for (const double value : verify.value) {
    sum += value;
    squares += value * value;
  }
  const double n = std::max(1, verify.size());
  contrast = std::sqrt(std::max(0.0, squares / n - (sum / n) * (sum / n)));
  CoarseGrid grid{angle_deg, scale_x, scale_y, p.common_scale, p.angle_step_deg, p.scale_step};
  hypotheses = vsfind::hypotheses(grid);
}

Freedom PreparedPattern::fine_freedom() const {
  Freedom fine = freedom;
  fine.blur = true;
  fine.shading = true;
  return fine;
}

std::vector<Eigen::Vector2d> PreparedPattern::outline(const Pose& pose) const {
  const Pattern& p = *pattern;
  std::vector<Eigen::Vector2d> corners;
  for (const auto& [x, y] : {std::pair(p.left, p.top), std::pair(p.left + p.width, p.top),
                             std::pair(p.left + p.width, p.top + p.height), std::pair(p.left, p.top + p.height)}) {
    corners.push_back(plane_from_pattern(pose, Eigen::Vector2d(x, y) * p.pitch));
  }
  return corners;
}

double area(const std::vector<Eigen::Vector2d>& polygon) {
  double twice = 0.0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& a = polygon[i];
    const Eigen::Vector2d& b = polygon[(i + 1) % polygon.size()];
    twice += a.x() * b.y() - b.x() * a.y();
  }
  return std::abs(twice) / 2.0;
}

double shared_area(const std::vector<Eigen::Vector2d>& a, const std::vector<Eigen::Vector2d>& b) {
  // Sutherland & Hodgman: cut polygon a along every side of b. Both run the same way round (x to y).
  std::vector<Eigen::Vector2d> rest = a;
  for (std::size_t i = 0; i < b.size() && !rest.empty(); ++i) {
    const Eigen::Vector2d from = b[i];
    const Eigen::Vector2d along = b[(i + 1) % b.size()] - from;
    const auto side = [&](const Eigen::Vector2d& p) {
      return along.x() * (p.y() - from.y()) - along.y() * (p.x() - from.x());
    };
    std::vector<Eigen::Vector2d> kept;
    for (std::size_t k = 0; k < rest.size(); ++k) {
      const Eigen::Vector2d& p = rest[k];
      const Eigen::Vector2d& q = rest[(k + 1) % rest.size()];
      const double sp = side(p);
      const double sq = side(q);
      if (sp >= 0.0) kept.push_back(p);
      if ((sp >= 0.0) != (sq >= 0.0)) kept.push_back(p + (q - p) * (sp / (sp - sq)));
    }
    rest = std::move(kept);
  }
  return area(rest);
}

}  // namespace vsfind
