#include "finder/informative_points.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "finder/training_scene.h"

namespace vsfind {

Eigen::VectorXd pose_derivatives(const PatternPoint& point, const Freedom& freedom) {
  const auto gx = static_cast<double>(point.gradient_x);
  const auto gy = static_cast<double>(point.gradient_y);
  Eigen::VectorXd j(2 + (freedom.angle ? 1 : 0) +
                    (freedom.common_scale ? 1 : (freedom.scale_x ? 1 : 0) + (freedom.scale_y ? 1 : 0)) +
                    (freedom.blur ? 3 : 0));
  Eigen::Index k = 0;
  j(k++) = gx;
  j(k++) = gy;
  if (freedom.angle) j(k++) = gy * point.x - gx * point.y;
  if (freedom.common_scale) {
    j(k++) = gx * point.x + gy * point.y;
  } else {
    if (freedom.scale_x) j(k++) = gx * point.x;
    if (freedom.scale_y) j(k++) = gy * point.y;
  }
  if (freedom.blur) {
    j(k++) = static_cast<double>(point.value);
    j(k++) = 1.0;
    j(k++) = static_cast<double>(point.laplacian);
  }
  return j;
}

namespace {

/// Occupied places, in cells of the spacing.
class Occupied {
 public:
  Occupied(const std::vector<PatternPoint>& points, double spacing) : spacing_(spacing) {
    for (const PatternPoint& p : points) {
      left_ = std::min(left_, p.x);
      top_ = std::min(top_, p.y);
      right_ = std::max(right_, p.x);
      bottom_ = std::max(bottom_, p.y);
    }
    columns_ = static_cast<int>((right_ - left_) / spacing_) + 1;
    rows_ = static_cast<int>((bottom_ - top_) / spacing_) + 1;
    cells_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
  }

  [[nodiscard]] bool free(const PatternPoint& p) const {
    const int c = column(p);
    const int r = row(p);
    for (int y = std::max(0, r - 1); y <= std::min(rows_ - 1, r + 1); ++y) {
      for (int x = std::max(0, c - 1); x <= std::min(columns_ - 1, c + 1); ++x) {
        for (const auto& q : cells_[cell(x, y)]) {
          if (std::hypot(q.x() - p.x, q.y() - p.y) < spacing_ * 0.999) return false;
        }
      }
    }
    return true;
  }
  void take(const PatternPoint& p) { cells_[cell(column(p), row(p))].emplace_back(p.x, p.y); }
  /// Cell of an n × n grid over all candidates.
  [[nodiscard]] std::size_t region(const PatternPoint& p, int n) const {
    const int c = std::min(n - 1, static_cast<int>(n * (p.x - left_) / std::max(1e-9, right_ - left_)));
    const int r = std::min(n - 1, static_cast<int>(n * (p.y - top_) / std::max(1e-9, bottom_ - top_)));
    return static_cast<std::size_t>(r) * static_cast<std::size_t>(n) + static_cast<std::size_t>(c);
  }

 private:
  [[nodiscard]] std::size_t cell(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
  }
  [[nodiscard]] int column(const PatternPoint& p) const { return static_cast<int>((p.x - left_) / spacing_); }
  [[nodiscard]] int row(const PatternPoint& p) const { return static_cast<int>((p.y - top_) / spacing_); }

  double spacing_;
  double left_ = 1e300;
  double top_ = 1e300;
  double right_ = -1e300;
  double bottom_ = -1e300;
  int columns_ = 0;
  int rows_ = 0;
  std::vector<std::vector<Eigen::Vector2d>> cells_;
};

/// A number in 0 … 1 that looks random and depends on the index alone.
double scatter(std::size_t index) {
  std::uint64_t z = static_cast<std::uint64_t>(index) + 0x9E3779B97F4A7C15ULL;
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
  return static_cast<double>((z ^ (z >> 31U)) >> 11U) * 0x1.0p-53;
}

}  // namespace

std::vector<std::size_t> choose_informative(const std::vector<PatternPoint>& candidates, const Freedom& freedom,
                                            std::size_t count, double spacing, bool spread) {
  std::vector<std::size_t> chosen;
  if (candidates.empty() || count == 0) return chosen;
  const std::size_t n = candidates.size();
  const Eigen::Index p = pose_derivatives(candidates[0], freedom).size();
  Eigen::MatrixXd j(p, static_cast<Eigen::Index>(n));
  for (std::size_t i = 0; i < n; ++i) j.col(static_cast<Eigen::Index>(i)) = pose_derivatives(candidates[i], freedom);
  // Start from a small part of the information of all points, so that the first leverages mean something.
  Eigen::MatrixXd information = j * j.transpose() * (0.01 / static_cast<double>(n));
  information.diagonal().array() += 1e-9 * information.diagonal().maxCoeff() + 1e-12;

  Occupied places(candidates, spacing);
  constexpr int regions = 8;
  constexpr std::size_t all_regions = std::size_t{regions} * regions;
  std::vector<std::size_t> share(all_regions, 0);
  bool moves_only = !freedom.angle && !freedom.scale_x && !freedom.scale_y && !freedom.common_scale;
  constexpr double more_than_share = 1.1;
  std::vector<double> quota;
  std::vector<char> used(n, 0);
  std::vector<double> worth(n);
  std::vector<std::size_t> order(n);
  constexpr std::size_t batches = 12;
  const std::size_t batch = std::max<std::size_t>(1, (count + batches - 1) / batches);
  // What is fitted beside the pose is not asked for: a point is worth what it adds to the determinant of the pose's own
  // information, the nuisances eliminated (D_s-optimal design), which is the leverage less that of the nuisances alone.
  const Eigen::Index nuisances = freedom.blur ? 3 : 0;
  while (chosen.size() < count) {
    const Eigen::MatrixXd half = information.llt().matrixL().solve(j);
    Eigen::VectorXd leverage = half.colwise().squaredNorm();
    if (nuisances > 0) {
      const Eigen::MatrixXd of_nuisances = information.bottomRightCorner(nuisances, nuisances);
      const Eigen::MatrixXd their_half = of_nuisances.llt().matrixL().solve(j.bottomRows(nuisances));
      leverage -= their_half.colwise().squaredNorm();
    }
    for (std::size_t i = 0; i < n; ++i) {
      // The scatter spreads the choice among points of like worth, instead of taking them in reading order.
      worth[i] = used[i] != 0 ? -1.0 : std::max(0.0, leverage(static_cast<Eigen::Index>(i))) * (0.8 + 0.2 * scatter(i));
    }
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return worth[a] != worth[b] ? worth[a] > worth[b] : a < b; });
    if (moves_only && quota.empty()) {
      double total = 0.0;
      quota.assign(all_regions, 0.0);
      for (std::size_t i = 0; i < n; ++i) {
        quota[places.region(candidates[i], regions)] += worth[i];
        total += worth[i];
      }
      for (double& each : quota) each = std::max(1.0, more_than_share * static_cast<double>(count) * each / total);
    }
    std::size_t added = 0;
    const std::size_t even_share = (chosen.size() + batch) / all_regions + 1;
    for (const std::size_t i : order) {
      if (added == batch || chosen.size() == count || worth[i] < 0.0) break;
      const std::size_t region = places.region(candidates[i], regions);
      if (spread && share[region] >= even_share) continue;
      if (!quota.empty() && static_cast<double>(share[region]) >= quota[region]) continue;
      if (!places.free(candidates[i])) continue;
      places.take(candidates[i]);
      used[i] = 1;
      ++share[region];
      chosen.push_back(i);
      const auto column = j.col(static_cast<Eigen::Index>(i));
      information += column * column.transpose();
      ++added;
    }
    if (added == 0) {
      if (!spread && quota.empty()) break;
      // Every region that has points has given its share.
      spread = false;
      moves_only = false;
      quota.clear();
    }
  }
  return chosen;
}

PointInflation inflation_of(const std::vector<PatternPoint>& points, const Freedom& freedom) {
  PointInflation inflation = PointInflation::Ones();
  if (points.empty()) return inflation;
  const Eigen::Index p = pose_derivatives(points[0], freedom).size();
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(p, p);
  Eigen::MatrixXd with_neighbours = Eigen::MatrixXd::Zero(p, p);
  std::vector<Eigen::VectorXd> j;
  j.reserve(points.size());
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

}  // namespace vsfind
