#include "finder/coarse_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "finder/kernels.h"

namespace vsfind {

CoarsePoints::CoarsePoints(const std::vector<PatternPoint>& points) {
  double mean = 0.0;
  double most = 1e-6;
  for (const PatternPoint& point : points) mean += static_cast<double>(point.value);
  mean /= std::max(1.0, static_cast<double>(points.size()));
  for (const PatternPoint& point : points) most = std::max(most, std::abs(static_cast<double>(point.value) - mean));
  double left = 0.0;
  double right = 0.0;
  double top = 0.0;
  double bottom = 0.0;
  for (const PatternPoint& point : points) {
    const bool first = x.empty();
    left = first ? point.x : std::min(left, point.x);
    right = first ? point.x : std::max(right, point.x);
    top = first ? point.y : std::min(top, point.y);
    bottom = first ? point.y : std::max(bottom, point.y);
    x.push_back(point.x);
    y.push_back(point.y);
    const auto w = static_cast<std::int16_t>(std::lround(127.0 * (static_cast<double>(point.value) - mean) / most));
    weight.push_back(w);
    weight_squared.push_back(static_cast<std::int16_t>(w * w));
  }
  anchor_x = (left + right) / 2.0;
  anchor_y = (top + bottom) / 2.0;
}

void CoarseSearch::prepare_plane(const Level& level, int margin) {
  const bool same = width_ == level.width && height_ == level.height && margin_ == margin;
  width_ = level.width;
  height_ = level.height;
  margin_ = margin;
  stride_ = width_ + 2 * margin;
  const auto size =
      static_cast<std::size_t>(stride_) * static_cast<std::size_t>(height_ + 2 * margin) + kernels::read_slack;
  if (!same) {
    plane_.assign(size, 128);
    mask_.assign(size, 128);
  }
  for (int v = 0; v < height_; ++v) {
    const std::ptrdiff_t to = (v + margin) * stride_ + margin;
    std::copy_n(level.row(v), width_, plane_.data() + to);
    if (!same) std::fill_n(mask_.data() + to, width_, std::uint8_t{129});
  }
}

namespace {

/// Where the points of one hypothesis fall, relative to the anchor, in whole level pixels.
struct Copy {
  std::vector<std::ptrdiff_t> offsets;
  int left = 0;
  int right = 0;
  int top = 0;
  int bottom = 0;
  Eigen::Vector2d origin{0.0, 0.0};  ///< of the pattern relative to the anchor, level pixels
};

/// Sums of one row of positions.
struct RowSums {
  std::vector<std::int32_t> sum, square, dot, count, weight, weight_squared, unused;
  explicit RowSums(std::size_t n) : sum(n), square(n), dot(n), count(n), weight(n), weight_squared(n), unused(n) {}
};

float oriented(float correlation, Polarity polarity) {
  return polarity == Polarity::same       ? correlation
         : polarity == Polarity::reversed ? -correlation
                                          : std::abs(correlation);
}

}  // namespace

void CoarseSearch::run(const CoarseTask& task, ThreadPool& threads, std::vector<CoarseCandidate>& out) {
  out.clear();
  const Level& level = *task.projection.level;
  const CoarsePoints& points = *task.points;
  const std::vector<Hypothesis>& tried = *task.hypotheses;
  const int n = points.size();
  if (n < 4 || tried.empty() || level.width < 1 || level.height < 1) return;

  const Eigen::Vector2d centre = task.projection.mapping->plane_from_image(
      level.image_from_level({(level.width - 1) / 2.0, (level.height - 1) / 2.0}));
  const Eigen::Matrix2d level_from_plane = task.projection.level_from_plane_jacobian(centre) * task.projection.pitch;
  std::vector<Copy> copies(tried.size());
  std::vector<std::pair<int, int>> whole(static_cast<std::size_t>(n));
  int margin = 0;
  std::vector<std::vector<std::pair<int, int>>> steps(tried.size());
  for (std::size_t h = 0; h < tried.size(); ++h) {
    const double angle = tried[h].angle_deg * std::numbers::pi / 180.0;
    Eigen::Matrix2d turn;
    turn << std::cos(angle) * tried[h].scale_x, -std::sin(angle) * tried[h].scale_y, std::sin(angle) * tried[h].scale_x,
        std::cos(angle) * tried[h].scale_y;
    const Eigen::Matrix2d m = level_from_plane * turn;
    Copy& copy = copies[h];
    copy.origin = m * Eigen::Vector2d(-points.anchor_x, -points.anchor_y);
    for (int i = 0; i < n; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const Eigen::Vector2d p = m * Eigen::Vector2d(points.x[k] - points.anchor_x, points.y[k] - points.anchor_y);
      const int du = static_cast<int>(std::lround(p.x()));
      const int dv = static_cast<int>(std::lround(p.y()));
      steps[h].emplace_back(du, dv);
      copy.left = std::min(copy.left, du);
      copy.right = std::max(copy.right, du);
      copy.top = std::min(copy.top, dv);
      copy.bottom = std::max(copy.bottom, dv);
    }
    margin = std::max({margin, -copy.left, copy.right, -copy.top, copy.bottom});
  }
  // Positions are handled in blocks of 32: the last block may run over the right edge.
  prepare_plane(level, margin + 32);
  for (std::size_t h = 0; h < tried.size(); ++h) {
    for (const auto& [du, dv] : steps[h]) copies[h].offsets.push_back(dv * stride_ + du);
  }

  double sum_w = 0.0;
  double sum_ww = 0.0;
  for (int i = 0; i < n; ++i) {
    sum_w += points.weight[static_cast<std::size_t>(i)];
    sum_ww += points.weight_squared[static_cast<std::size_t>(i)];
  }
  const double variance_w = n * sum_ww - sum_w * sum_w;
  const auto area = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  const int workers = threads.size();
  best_.assign(area * static_cast<std::size_t>(workers), task.threshold);
  which_.assign(area * static_cast<std::size_t>(workers), 0);
  const auto flat = static_cast<float>(n) * static_cast<float>(n);  // a standard deviation of one grey level
  const int least_inside = static_cast<int>(std::ceil(task.min_inside * static_cast<float>(n)));

  const auto search = [&](int worker) {
    float* best = best_.data() + area * static_cast<std::size_t>(worker);
    std::uint16_t* which = which_.data() + area * static_cast<std::size_t>(worker);
    RowSums row(static_cast<std::size_t>(width_) + 64);
    const std::size_t from = tried.size() * static_cast<std::size_t>(worker) / static_cast<std::size_t>(workers);
    const std::size_t to = tried.size() * static_cast<std::size_t>(worker + 1) / static_cast<std::size_t>(workers);
    for (std::size_t h = from; h < to; ++h) {
      const Copy& copy = copies[h];
      int first_u = 0;
      int last_u = width_ - 1;
      int first_v = 0;
      int last_v = height_ - 1;
      if (task.region != nullptr) {
        // The region is for the origin; the anchor is shifted from it. One pixel more for the rounding.
        const Roi& r = *task.region;
        const double step = line_step(task.projection.mapping->field());
        const double line = first_line(task.projection.mapping->field());
        const Eigen::Vector2d a = level.level_from_image({r.x - 0.5, (r.y - 0.5 - line) / step}) - copy.origin;
        const Eigen::Vector2d b =
            level.level_from_image({r.x + r.width - 0.5, (r.y + r.height - 0.5 - line) / step}) - copy.origin;
        first_u = std::max(first_u, static_cast<int>(std::floor(a.x())) - 1);
        first_v = std::max(first_v, static_cast<int>(std::floor(a.y())) - 1);
        last_u = std::min(last_u, static_cast<int>(std::ceil(b.x())) + 1);
        last_v = std::min(last_v, static_cast<int>(std::ceil(b.y())) + 1);
      }
      for (int v = first_v; v <= last_v; ++v) {
        if (first_u > last_u) break;
        const int count = last_u - first_u + 1;
        const std::ptrdiff_t base = (v + margin_) * stride_ + margin_ + first_u;
        kernels::correlate_row(plane_.data() + base, copy.offsets.data(), points.weight.data(), n, count,
                               row.sum.data(), row.square.data(), row.dot.data());
        const bool whole_row = v + copy.top >= 0 && v + copy.bottom < height_;
        const int inner_first = whole_row ? std::max(first_u, -copy.left) : last_u + 1;
        const int inner_last = whole_row ? std::min(last_u, width_ - 1 - copy.right) : last_u;
        float* best_row = best + static_cast<std::ptrdiff_t>(v) * width_;
        std::uint16_t* which_row = which + static_cast<std::ptrdiff_t>(v) * width_;
        const auto take = [&](int u, float correlation) {
          const float score = oriented(correlation, task.polarity);
          if (score > best_row[u]) {
            best_row[u] = score;
            which_row[u] = static_cast<std::uint16_t>(h);
          }
        };
        const auto fn = static_cast<float>(n);
        const auto fw = static_cast<float>(sum_w);
        const auto vw = static_cast<float>(variance_w);
        for (int u = inner_first; u <= inner_last; ++u) {
          const auto p = static_cast<std::size_t>(u - first_u);
          const auto s = static_cast<float>(row.sum[p]);
          const float variance = fn * static_cast<float>(row.square[p]) - s * s;
          if (variance < flat) continue;
          take(u, (fn * static_cast<float>(row.dot[p]) - fw * s) / std::sqrt(variance * vw));
        }
        const auto border = [&](int a, int b) {
          if (a > b) return;
          const std::ptrdiff_t at = (v + margin_) * stride_ + margin_ + a;
          const int some = b - a + 1;
          kernels::correlate_row(mask_.data() + at, copy.offsets.data(), points.weight.data(), n, some,
                                 row.count.data(), row.unused.data(), row.weight.data());
          kernels::correlate_row(mask_.data() + at, copy.offsets.data(), points.weight_squared.data(), n, some,
                                 row.count.data(), row.unused.data(), row.weight_squared.data());
          for (int u = a; u <= b; ++u) {
            const auto q = static_cast<std::size_t>(u - a);
            const auto p = static_cast<std::size_t>(u - first_u);
            const std::int32_t inside = row.count[q];
            if (inside < least_inside) continue;
            const auto m = static_cast<float>(inside);
            const auto s = static_cast<float>(row.sum[p]);
            const auto w = static_cast<float>(row.weight[q]);
            const float variance = m * static_cast<float>(row.square[p]) - s * s;
            const float weights = m * static_cast<float>(row.weight_squared[q]) - w * w;
            if (variance < m * m || weights < m * m) continue;
            take(u, (m * static_cast<float>(row.dot[p]) - w * s) / std::sqrt(variance * weights));
          }
        };
        border(first_u, std::min(inner_first - 1, last_u));
        border(std::max(inner_last + 1, first_u), whole_row ? last_u : first_u - 1);
      }
    }
  };
  threads.run(search);
  for (int worker = 1; worker < workers; ++worker) {
    const float* other = best_.data() + area * static_cast<std::size_t>(worker);
    const std::uint16_t* which = which_.data() + area * static_cast<std::size_t>(worker);
    for (std::size_t i = 0; i < area; ++i) {
      // Hypotheses are shared out in order: only a better one of a later share wins, as with one thread.
      if (other[i] > best_[i]) {
        best_[i] = other[i];
        which_[i] = which[i];
      }
    }
  }

  struct Peak {
    float score;
    int at;
  };
  std::vector<Peak> peaks;
  for (int v = 0; v < height_; ++v) {
    for (int u = 0; u < width_; ++u) {
      const int at = v * width_ + u;
      const float score = best_[static_cast<std::size_t>(at)];
      if (score <= task.threshold) continue;
      bool highest = true;
      for (int dv = -1; dv <= 1 && highest; ++dv) {
        for (int du = -1; du <= 1 && highest; ++du) {
          const int x = u + du;
          const int y = v + dv;
          if ((du == 0 && dv == 0) || x < 0 || y < 0 || x >= width_ || y >= height_) continue;
          const int other = y * width_ + x;
          const float its = best_[static_cast<std::size_t>(other)];
          highest = its < score || (its == score && other > at);
        }
      }
      if (highest) peaks.push_back({score, at});
    }
  }
  const auto better = [](const Peak& a, const Peak& b) { return a.score != b.score ? a.score > b.score : a.at < b.at; };
  const std::size_t kept = std::min(task.most, peaks.size());
  std::partial_sort(peaks.begin(), peaks.begin() + static_cast<std::ptrdiff_t>(kept), peaks.end(), better);
  for (std::size_t i = 0; i < kept; ++i) {
    const std::size_t h = which_[static_cast<std::size_t>(peaks[i].at)];
    const Eigen::Vector2d anchor(peaks[i].at % width_, peaks[i].at / width_);
    const Eigen::Vector2d plane =
        task.projection.mapping->plane_from_image(level.image_from_level(anchor + copies[h].origin));
    out.push_back({{plane.x(), plane.y(), tried[h].angle_deg, tried[h].scale_x, tried[h].scale_y}, peaks[i].score});
  }
}

}  // namespace vsfind
