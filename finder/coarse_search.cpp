#include "finder/coarse_search.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <numbers>
#include <numeric>

#include "finder/kernels.h"

namespace vsfind {

namespace {

/// Weights for the first pass: whole numbers that sum to zero, small enough for 16-bit sums.
std::vector<std::int8_t> first_weights(const std::vector<PatternPoint>& points) {
  constexpr std::size_t most = 40;  // the rest of the points adds little: they are in their order of choice
  const std::size_t n = std::min(most, points.size() / 2 * 2);
  double mean = 0.0;
  for (std::size_t i = 0; i < n; ++i) mean += static_cast<double>(points[i].value) / static_cast<double>(n);
  double total = 1e-6;
  for (std::size_t i = 0; i < n; ++i) total += std::abs(static_cast<double>(points[i].value) - mean);
  // Rounding, and what it takes to make the sum zero, stay within the limit.
  const double scale = (kernels::most_weight - static_cast<double>(n)) / total;
  std::vector<std::int8_t> weights(n);
  std::vector<std::pair<double, std::size_t>> rounding(n);
  int sum = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double exact = std::clamp(scale * (static_cast<double>(points[i].value) - mean), -120.0, 120.0);
    const auto whole = static_cast<int>(std::lround(exact));
    weights[i] = static_cast<std::int8_t>(whole);
    rounding[i] = {exact - whole, i};
    sum += whole;
  }
  std::sort(rounding.begin(), rounding.end());
  // Those rounded up the most are lowered, or those rounded down the most raised.
  for (std::size_t i = 0; sum > 0; i = (i + 1) % n, --sum) --weights[rounding[i].second];
  for (std::size_t i = 0; sum < 0; i = (i + 1) % n, ++sum) ++weights[rounding[n - 1 - i].second];
  return weights;
}

/// Of a pattern that lies in the picture with all its points.
constexpr std::int16_t whole_factor = 16384;

}  // namespace

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
    const bool none = x.empty();
    left = none ? point.x : std::min(left, point.x);
    right = none ? point.x : std::max(right, point.x);
    top = none ? point.y : std::min(top, point.y);
    bottom = none ? point.y : std::max(bottom, point.y);
    x.push_back(point.x);
    y.push_back(point.y);
    weight.push_back(static_cast<std::int16_t>(std::lround(127.0 * (static_cast<double>(point.value) - mean) / most)));
  }
  weight.resize((weight.size() + kernels::sum_block - 1) / kernels::sum_block * kernels::sum_block, 0);
  if (points.size() >= 2) first = first_weights(points);
  anchor_x = (left + right) / 2.0;
  anchor_y = (top + bottom) / 2.0;
}

void CoarseSearch::prepare_copies(const CoarseTask& task) {
  const Level& level = *task.projection.level;
  const CoarsePoints& points = *task.points;
  const std::vector<Hypothesis>& tried = *task.hypotheses;
  const Eigen::Vector2d centre = task.projection.mapping->plane_from_image(
      level.image_from_level({(level.width - 1) / 2.0, (level.height - 1) / 2.0}));
  const Eigen::Matrix2d slope = task.projection.level_from_plane_jacobian(centre) * task.projection.pitch;
  const bool same = copied_points_ == &points && copied_hypotheses_ == &tried && copied_slope_ == slope &&
                    copies_.size() == tried.size() && width_ == level.width && height_ == level.height;
  if (same) return;
  copied_points_ = &points;
  copied_hypotheses_ = &tried;
  copied_slope_ = slope;
  copies_.resize(tried.size());
  margin_ = 0;
  const auto n = static_cast<std::size_t>(points.size());
  for (std::size_t h = 0; h < tried.size(); ++h) {
    const double angle = tried[h].angle_deg * std::numbers::pi / 180.0;
    Eigen::Matrix2d turn;
    turn << std::cos(angle) * tried[h].scale_x, -std::sin(angle) * tried[h].scale_y, std::sin(angle) * tried[h].scale_x,
        std::cos(angle) * tried[h].scale_y;
    const Eigen::Matrix2d m = slope * turn;
    Copy& copy = copies_[h];
    copy = {};
    copy.origin = m * Eigen::Vector2d(-points.anchor_x, -points.anchor_y);
    for (std::size_t k = 0; k < n; ++k) {
      const Eigen::Vector2d p = m * Eigen::Vector2d(points.x[k] - points.anchor_x, points.y[k] - points.anchor_y);
      const int du = static_cast<int>(std::lround(std::clamp(p.x(), -16000.0, 16000.0)));
      const int dv = static_cast<int>(std::lround(std::clamp(p.y(), -16000.0, 16000.0)));
      copy.du.push_back(static_cast<std::int16_t>(du));
      copy.dv.push_back(static_cast<std::int16_t>(dv));
      copy.left = std::min(copy.left, du);
      copy.right = std::max(copy.right, du);
      copy.top = std::min(copy.top, dv);
      copy.bottom = std::max(copy.bottom, dv);
    }
    copy.du.resize(points.weight.size(), 0);
    copy.dv.resize(points.weight.size(), 0);
    margin_ = std::max({margin_, -copy.left, copy.right, -copy.top, copy.bottom});
  }
  width_ = level.width;
  height_ = level.height;
  stride_ = width_ + 2 * static_cast<std::ptrdiff_t>(margin_) + kernels::dot_block;
  row_ = (width_ + 2 * kernels::dot_block - 1) / kernels::dot_block * kernels::dot_block;
  plane_.assign(
      static_cast<std::size_t>(stride_) * static_cast<std::size_t>(height_ + 2 * margin_) + kernels::read_slack, 0);
  for (Copy& copy : copies_) {
    for (std::size_t k = 0; k < n; ++k) copy.offsets.push_back(copy.dv[k] * stride_ + copy.du[k]);
  }
  for (Copy& copy : copies_) prepare_factors(points, task.min_inside, copy);
  // A row above and one below the scores, and an entry to either side: lower than any score.
  scores_.assign(static_cast<std::size_t>(row_) * static_cast<std::size_t>(height_ + 2) + 2, 0);
  which_.resize(static_cast<std::size_t>(row_) * static_cast<std::size_t>(height_));
  columns_.resize(static_cast<std::size_t>(width_));
}

void CoarseSearch::prepare_factors(const CoarsePoints& points, float min_inside, Copy& copy) const {
  copy.upper_rows = std::min(height_, -copy.top);
  copy.lower_rows = std::min(height_ - copy.upper_rows, copy.bottom);
  copy.factors.clear();
  const std::size_t n = points.first.size();
  int whole = 0;
  for (const std::int8_t weight : points.first) whole += weight * weight;
  const auto least = static_cast<int>(std::ceil(min_inside * static_cast<float>(n)));
  struct Inside {
    int count = 0;
    int weights = 0;
    int squares = 0;
  };
  std::vector<Inside> row(static_cast<std::size_t>(width_));
  // Of the rows that see the pattern cut off above or below, and of one that does not.
  const auto add_row = [&](auto is_inside) {
    std::fill(row.begin(), row.end(), Inside{});
    for (std::size_t k = 0; k < n; ++k) {
      if (!is_inside(copy.dv[k])) continue;
      const int weight = +points.first[k];
      const int last = std::min(width_ - 1, width_ - 1 - copy.du[k]);
      for (int u = std::max(0, -copy.du[k]); u <= last; ++u) {
        Inside& at = row[static_cast<std::size_t>(u)];
        ++at.count;
        at.weights += weight;
        at.squares += weight * weight;
      }
    }
    for (const Inside& at : row) {
      // What is seen of the weights: their mean taken out, as large as all of them together.
      const double mean = static_cast<double>(at.weights) / std::max(1, at.count);
      const double squares = std::max(1.0, at.squares - mean * at.weights);
      const double factor = at.count < least ? 0.0 : std::min(1.99, std::sqrt(whole / squares));
      copy.factors.push_back(static_cast<std::int16_t>(std::lround(whole_factor * factor)));
    }
    copy.factors.resize(copy.factors.size() + static_cast<std::size_t>(row_ - width_), 0);
  };
  for (int v = 0; v < copy.upper_rows; ++v) add_row([&](int dv) { return v + dv >= 0 && v + dv < height_; });
  add_row([](int) { return true; });
  for (int v = height_ - copy.lower_rows; v < height_; ++v) {
    add_row([&](int dv) { return v + dv >= 0 && v + dv < height_; });
  }
}

const std::int16_t* CoarseSearch::factors_of(const Copy& copy, int v) const {
  const int first_lower = height_ - copy.lower_rows;
  const int row = v < copy.upper_rows ? v : copy.upper_rows + (v < first_lower ? 0 : v - first_lower + 1);
  return copy.factors.data() + static_cast<std::ptrdiff_t>(row) * row_;
}

void CoarseSearch::prepare_plane(const Level& level) {
  std::uint8_t least = 0;
  std::uint8_t most = 0;
  kernels::range_of(level.row(0), level.row(1) - level.row(0), width_, height_, least, most);
  const auto factor = static_cast<std::uint16_t>(127 * 256 / std::max(1, most - least));
  for (int v = 0; v < height_; ++v) {
    kernels::stretch(level.row(v), width_, least, factor, plane_row(v));
  }
  // Around the picture lies the mean of what is near its border: so the weights' part that is outside, where they do
  // not sum to zero, finds nothing unusual.
  constexpr int near = 8;
  const int depth_x = std::min(near, width_);
  const int depth_y = std::min(near, height_);
  const auto settle = [&](std::vector<int>& sums, int depth) {
    // From sums over the depth to means over as much along the border.
    const int n = static_cast<int>(sums.size());
    running_.assign(1, 0);
    for (const int sum : sums) running_.push_back(running_.back() + sum);
    for (int i = 0; i < n; ++i) {
      const int from = std::max(0, i - near / 2);
      const int to = std::min(n, i + near / 2 + 1);
      sums[static_cast<std::size_t>(i)] =
          (running_[static_cast<std::size_t>(to)] - running_[static_cast<std::size_t>(from)]) / ((to - from) * depth);
    }
  };
  const auto along_rows = [&](int first, int end, std::vector<int>& sums) {
    sums.assign(static_cast<std::size_t>(height_), 0);
    for (int v = 0; v < height_; ++v) {
      const std::uint8_t* row = plane_row(v);
      sums[static_cast<std::size_t>(v)] = std::accumulate(row + first, row + end, 0);
    }
    settle(sums, depth_x);
  };
  along_rows(0, depth_x, left_);
  along_rows(width_ - depth_x, width_, right_);
  for (int v = 0; v < height_; ++v) {
    std::uint8_t* row = plane_row(v);
    std::fill(row - margin_, row, static_cast<std::uint8_t>(left_[static_cast<std::size_t>(v)]));
    std::fill(row + width_, row + stride_ - margin_, static_cast<std::uint8_t>(right_[static_cast<std::size_t>(v)]));
  }
  const auto beyond = [&](int first, int border, int direction) {
    edge_.assign(static_cast<std::size_t>(width_), 0);
    for (int v = first; v < first + depth_y; ++v) {
      const std::uint8_t* row = plane_row(v);
      for (int u = 0; u < width_; ++u) edge_[static_cast<std::size_t>(u)] += row[u];
    }
    settle(edge_, depth_y);
    for (int k = 1; k <= margin_; ++k) {
      std::uint8_t* row = plane_row(border + k * direction);
      std::copy_n(plane_row(border) - margin_, stride_, row - margin_);
      for (int u = 0; u < width_; ++u) row[u] = static_cast<std::uint8_t>(edge_[static_cast<std::size_t>(u)]);
    }
  };
  beyond(0, 0, -1);
  beyond(height_ - depth_y, height_ - 1, 1);
}

CoarseSearch::Window CoarseSearch::window_of(const CoarseTask& task, const Copy& copy) const {
  Window window{0, width_ - 1, 0, height_ - 1};
  if (task.region == nullptr) return window;
  // The region is for the origin; the anchor is shifted from it. One pixel more for the rounding.
  const Roi& r = *task.region;
  const Level& level = *task.projection.level;
  const double step = line_step(task.projection.mapping->field());
  const double line = first_line(task.projection.mapping->field());
  const Eigen::Vector2d a = level.level_from_image({r.x - 0.5, (r.y - 0.5 - line) / step}) - copy.origin;
  const Eigen::Vector2d b =
      level.level_from_image({r.x + r.width - 0.5, (r.y + r.height - 0.5 - line) / step}) - copy.origin;
  window.left = std::max(window.left, static_cast<int>(std::floor(a.x())) - 1);
  window.top = std::max(window.top, static_cast<int>(std::floor(a.y())) - 1);
  window.right = std::min(window.right, static_cast<int>(std::ceil(b.x())) + 1);
  window.bottom = std::min(window.bottom, static_cast<int>(std::ceil(b.y())) + 1);
  return window;
}

bool CoarseSearch::first_pass(const CoarseTask& task, int first_row, int end_row) {
  const std::vector<std::int8_t>& weights = task.points->first;
  const int n = static_cast<int>(weights.size());
  const bool limited = task.deadline != std::chrono::steady_clock::time_point::max();
  for (int v = first_row; v < end_row; ++v) {
    if (limited && std::chrono::steady_clock::now() > task.deadline) return false;
    std::int16_t* scores = score_row(v);
    std::uint16_t* which = which_.data() + static_cast<std::ptrdiff_t>(v) * row_;
    std::fill_n(scores, row_, std::int16_t{0});
    const ColumnRange shown =
        task.shown != nullptr ? (*task.shown)[static_cast<std::size_t>(v)] : ColumnRange{0, width_ - 1};
    for (std::size_t h = 0; h < copies_.size(); ++h) {
      const Window& window = windows_[h];
      const int from = std::max(window.left, shown.left);
      const int to = std::min(window.right, shown.right);
      if (v < window.top || v > window.bottom || from > to) continue;
      kernels::best_dots(plane_row(v) + from, copies_[h].offsets.data(), weights.data(), n, to - from + 1,
                         task.polarity, factors_of(copies_[h], v) + from, static_cast<std::uint16_t>(h), scores + from,
                         which + from);
    }
    std::fill(scores + width_, scores + row_, std::int16_t{0});
  }
  return true;
}

float CoarseSearch::correlation(const CoarseTask& task, const Copy& copy, int u, int v) const {
  const CoarsePoints& points = *task.points;
  const std::uint8_t* at = plane_row(v) + u;
  const kernels::SparsePoints sparse{copy.offsets.data(), copy.du.data(), copy.dv.data(), points.weight.data(),
                                     points.size()};
  const kernels::SparseSums sums = kernels::sums_inside(at, sparse, -u, width_ - 1 - u, -v, height_ - 1 - v);
  const auto n = static_cast<float>(sums.count);
  if (n < std::max(4.0F, task.min_inside * static_cast<float>(points.size()))) return 0.0F;
  const auto sum = static_cast<float>(sums.pixels);
  const auto weights = static_cast<float>(sums.weights);
  const float variance = n * static_cast<float>(sums.squares) - sum * sum;
  const float spread = n * static_cast<float>(sums.weight_squares) - weights * weights;
  if (variance < n * n || spread < n * n) return 0.0F;  // flat
  return (n * static_cast<float>(sums.dots) - weights * sum) / std::sqrt(variance * spread);
}

void CoarseSearch::second_pass(const CoarseTask& task) {
  peaks_.clear();
  // What varies so little that it counts as flat cannot score more than this, nor what correlates too little. Half of
  // it, since the first pass has fewer points.
  double squares = 0.0;
  for (const std::int8_t weight : task.points->first) squares += weight * weight;
  const double flat = std::sqrt(squares * static_cast<double>(task.points->first.size()));
  const double least = 0.5 * static_cast<double>(task.threshold) * flat * whole_factor / 65536.0;
  const auto floor = static_cast<std::int16_t>(std::clamp(least, 1.0, 32767.0));
  for (int v = 0; v < height_; ++v) {
    const std::int16_t* row = score_row(v);
    const int found = kernels::local_maxima(row - row_, row, row + row_, width_, floor, columns_.data());
    for (int i = 0; i < found; ++i) {
      const int u = columns_[static_cast<std::size_t>(i)];
      const std::size_t h =
          which_[static_cast<std::size_t>(v) * static_cast<std::size_t>(row_) + static_cast<std::size_t>(u)];
      const float score = oriented(correlation(task, copies_[h], u, v), task.polarity);
      if (score > task.threshold) peaks_.push_back({score, u, v, h});
    }
  }
  const std::size_t kept = std::min(task.most, peaks_.size());
  std::partial_sort(peaks_.begin(), std::next(peaks_.begin(), static_cast<std::ptrdiff_t>(kept)), peaks_.end(), better);
  peaks_.resize(kept);
}

bool CoarseSearch::better(const Peak& a, const Peak& b) {
  if (a.score != b.score) return a.score > b.score;
  return a.v != b.v ? a.v < b.v : a.u != b.u ? a.u < b.u : a.hypothesis < b.hypothesis;
}

void CoarseSearch::other_ways(const CoarseTask& task) {
  constexpr std::size_t most_ways = 3;
  constexpr float as_good = 0.8F;
  constexpr float promising = 0.6F;
  constexpr double other_angle = 20.0;  // degrees: nearer ones lead to the same pose
  const std::vector<Hypothesis>& tried = *task.hypotheses;
  more_.clear();
  constexpr std::size_t at_least = 3;
  std::size_t looked_at = std::min(std::max(task.places, at_least), peaks_.size());
  while (looked_at > at_least && peaks_[looked_at - 1].score < as_good * peaks_.front().score) --looked_at;
  for (std::size_t i = 0; i < looked_at; ++i) {
    const Peak& peak = peaks_[i];
    ways_.clear();
    // Turned about its own origin, not about the middle of its points.
    const Eigen::Vector2d origin = Eigen::Vector2d(peak.u, peak.v) + copies_[peak.hypothesis].origin;
    for (std::size_t h = 0; h < copies_.size(); ++h) {
      const Eigen::Vector2d anchor = origin - copies_[h].origin;
      const auto at_u = static_cast<int>(std::lround(anchor.x()));
      const auto at_v = static_cast<int>(std::lround(anchor.y()));
      if (at_u < 0 || at_v < 0 || at_u >= width_ || at_v >= height_) continue;
      // The neighbours, too, where there is something to it.
      const float middle = oriented(correlation(task, copies_[h], at_u, at_v), task.polarity);
      const int reach = middle > promising * peak.score ? 1 : 0;
      for (int v = std::max(0, at_v - reach); v <= std::min(height_ - 1, at_v + reach); ++v) {
        for (int u = std::max(0, at_u - reach); u <= std::min(width_ - 1, at_u + reach); ++u) {
          const float score = oriented(correlation(task, copies_[h], u, v), task.polarity);
          if (score > as_good * peak.score) ways_.push_back({score, u, v, h});
        }
      }
    }
    std::sort(ways_.begin(), ways_.end(), better);
    const auto first = static_cast<std::ptrdiff_t>(more_.size());
    for (const Peak& way : ways_) {
      if (more_.size() >= static_cast<std::size_t>(first) + most_ways) break;
      const bool known = std::any_of(more_.begin() + first, more_.end(), [&](const Peak& other) {
        const double turn = tried[way.hypothesis].angle_deg - tried[other.hypothesis].angle_deg;
        return std::abs(std::remainder(turn, 360.0)) < other_angle;
      });
      if (!known) more_.push_back(way);
    }
  }
  peaks_.erase(peaks_.begin(), peaks_.begin() + static_cast<std::ptrdiff_t>(looked_at));
  peaks_.insert(peaks_.begin(), more_.begin(), more_.end());
  std::sort(peaks_.begin(), peaks_.end(), better);
}

bool CoarseSearch::run(const CoarseTask& task, ThreadPool& threads, std::vector<CoarseCandidate>& out) {
  out.clear();
  const Level& level = *task.projection.level;
  const std::vector<Hypothesis>& tried = *task.hypotheses;
  if (task.points->size() < 4 || tried.empty() || level.width < 1 || level.height < 1) return true;
  prepare_copies(task);
  prepare_plane(level);
  windows_.clear();
  for (const Copy& copy : copies_) windows_.push_back(window_of(task, copy));
  const int workers = threads.size();
  done_.assign(static_cast<std::size_t>(workers), 0);
  const auto job = [&](int worker) {
    const bool done = first_pass(task, height_ * worker / workers, height_ * (worker + 1) / workers);
    done_[static_cast<std::size_t>(worker)] = done ? 1 : 0;
  };
  threads.run(std::cref(job));  // a reference, which takes nothing from the heap
  if (std::find(done_.begin(), done_.end(), 0) != done_.end()) return false;
  second_pass(task);
  other_ways(task);
  for (const Peak& peak : peaks_) {
    const std::size_t h = peak.hypothesis;
    const Eigen::Vector2d anchor(peak.u, peak.v);
    const Eigen::Vector2d plane =
        task.projection.mapping->plane_from_image(level.image_from_level(anchor + copies_[h].origin));
    out.push_back({{plane.x(), plane.y(), tried[h].angle_deg, tried[h].scale_x, tried[h].scale_y}, peak.score});
  }
  return true;
}

}  // namespace vsfind
