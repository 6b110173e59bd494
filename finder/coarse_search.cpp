#include "finder/coarse_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>

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

float oriented(float correlation, Polarity polarity) {
  return polarity == Polarity::same       ? correlation
         : polarity == Polarity::reversed ? -correlation
                                          : std::abs(correlation);
}

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
}

void CoarseSearch::prepare_factors(const CoarsePoints& points, float min_inside, Copy& copy) const {
  const auto size = static_cast<std::size_t>(row_) * static_cast<std::size_t>(height_);
  copy.factors.assign(size, whole_factor);
  copy.shifts.assign(size, 0);
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
  for (int v = 0; v < height_; ++v) {
    const bool inner_row = v + copy.top >= 0 && v + copy.bottom < height_;
    std::fill(row.begin(), row.end(), Inside{});
    for (std::size_t k = 0; k < n; ++k) {
      if (v + copy.dv[k] < 0 || v + copy.dv[k] >= height_) continue;
      const int weight = +points.first[k];
      const int last = std::min(width_ - 1, width_ - 1 - copy.du[k]);
      for (int u = std::max(0, -copy.du[k]); u <= last; ++u) {
        Inside& at = row[static_cast<std::size_t>(u)];
        ++at.count;
        at.weights += weight;
        at.squares += weight * weight;
      }
    }
    for (int u = 0; u < width_; ++u) {
      if (inner_row && u + copy.left >= 0 && u + copy.right < width_) continue;
      const Inside& at = row[static_cast<std::size_t>(u)];
      const auto to = static_cast<std::size_t>(v) * static_cast<std::size_t>(row_) + static_cast<std::size_t>(u);
      // What is seen of the weights: their mean taken out, as large as all of them together.
      const double mean = static_cast<double>(at.weights) / std::max(1, at.count);
      const double squares = std::max(1.0, at.squares - mean * at.weights);
      const double factor = at.count < least ? 0.0 : std::min(1.99, std::sqrt(whole / squares));
      copy.factors[to] = static_cast<std::int16_t>(std::lround(whole_factor * factor));
      copy.shifts[to] = static_cast<std::int16_t>(std::clamp(std::lround(4096.0 * factor * mean), -32768L, 32767L));
    }
  }
}

void CoarseSearch::prepare_plane(const Level& level) {
  std::uint8_t least = 255;
  std::uint8_t most = 0;
  for (int v = 0; v < height_; ++v) {
    const auto [low, high] = std::minmax_element(level.row(v), level.row(v) + width_);
    least = std::min(least, *low);
    most = std::max(most, *high);
  }
  std::array<std::uint8_t, 256> stretched{};
  const int span = std::max(1, most - least);
  for (int grey = least; grey <= most; ++grey) {
    stretched[static_cast<std::size_t>(grey)] = static_cast<std::uint8_t>((grey - least) * 127 / span);
  }
  for (int v = 0; v < height_; ++v) {
    std::uint8_t* to = plane_.data() + static_cast<std::ptrdiff_t>(v + margin_) * stride_ + margin_;
    const std::uint8_t* from = level.row(v);
    for (int u = 0; u < width_; ++u) to[u] = stretched[from[u]];
  }
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

void CoarseSearch::first_pass(const CoarseTask& task, int first_row, int end_row) {
  const std::vector<std::int8_t>& weights = task.points->first;
  const int n = static_cast<int>(weights.size());
  for (int v = first_row; v < end_row; ++v) {
    std::int16_t* best = best_.data() + static_cast<std::ptrdiff_t>(v) * row_;
    std::uint16_t* which = which_.data() + static_cast<std::ptrdiff_t>(v) * row_;
    std::fill_n(best, row_, std::int16_t{0});
    const std::uint8_t* row = plane_.data() + static_cast<std::ptrdiff_t>(v + margin_) * stride_ + margin_;
    for (std::size_t h = 0; h < copies_.size(); ++h) {
      const Window& window = windows_[h];
      if (v < window.top || v > window.bottom || window.left > window.right) continue;
      const Copy& copy = copies_[h];
      const auto id = static_cast<std::uint16_t>(h);
      // Whole blocks where all points are inside go the quick way.
      const bool inner_row = v + copy.top >= 0 && v + copy.bottom < height_;
      const int inner = std::max(window.left, -copy.left);
      const int inner_count = inner_row ? std::max(0, std::min(window.right, width_ - 1 - copy.right) - inner + 1) : 0;
      const int quick = inner_count / kernels::dot_block * kernels::dot_block;
      const auto slowly = [&](int from, int count) {
        if (count <= 0) return;
        const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(v) * row_ + from;
        kernels::best_dots_inside(row + from, copy.offsets.data(), weights.data(), n, count, task.polarity,
                                  copy.factors.data() + at, copy.shifts.data() + at, id, best + from, which + from);
      };
      if (quick == 0) {
        slowly(window.left, window.right - window.left + 1);
        continue;
      }
      slowly(window.left, inner - window.left);
      kernels::best_dots(row + inner, copy.offsets.data(), weights.data(), n, quick, task.polarity, id, best + inner,
                         which + inner);
      slowly(inner + quick, window.right - inner - quick + 1);
    }
  }
}

float CoarseSearch::correlation(const CoarseTask& task, const Copy& copy, int u, int v) const {
  const CoarsePoints& points = *task.points;
  const std::uint8_t* at = plane_.data() + static_cast<std::ptrdiff_t>(v + margin_) * stride_ + margin_ + u;
  const bool inner = u + copy.left >= 0 && u + copy.right < width_ && v + copy.top >= 0 && v + copy.bottom < height_;
  const auto n = static_cast<std::size_t>(points.size());
  int count = 0;
  int sum = 0;
  int squares = 0;
  int dot = 0;
  int weights = 0;
  int weight_squares = 0;
  for (std::size_t k = 0; k < n; ++k) {
    if (!inner) {
      const int x = u + copy.du[k];
      const int y = v + copy.dv[k];
      if (x < 0 || y < 0 || x >= width_ || y >= height_) continue;
    }
    const int grey = at[copy.offsets[k]];
    const int w = points.weight[k];
    ++count;
    sum += grey;
    squares += grey * grey;
    dot += grey * w;
    weights += w;
    weight_squares += w * w;
  }
  if (static_cast<float>(count) < std::max(4.0F, task.min_inside * static_cast<float>(n))) return 0.0F;
  const auto m = static_cast<float>(count);
  const float variance = m * static_cast<float>(squares) - static_cast<float>(sum) * static_cast<float>(sum);
  const float spread =
      m * static_cast<float>(weight_squares) - static_cast<float>(weights) * static_cast<float>(weights);
  if (variance < m * m || spread < m * m) return 0.0F;  // flat
  return (m * static_cast<float>(dot) - static_cast<float>(weights) * static_cast<float>(sum)) /
         std::sqrt(variance * spread);
}

void CoarseSearch::second_pass(const CoarseTask& task) {
  peaks_.clear();
  for (int v = 0; v < height_; ++v) {
    const std::int16_t* here = best_.data() + static_cast<std::ptrdiff_t>(v) * row_;
    const std::int16_t* above = v > 0 ? here - row_ : nullptr;
    const std::int16_t* below = v + 1 < height_ ? here + row_ : nullptr;
    for (int u = 0; u < width_; ++u) {
      const std::int16_t dot = here[u];
      if (dot <= 0) continue;
      // Of equal neighbours the last one counts.
      bool highest = (u == 0 || here[u - 1] <= dot) && (u + 1 >= width_ || here[u + 1] < dot);
      for (int x = std::max(0, u - 1); x <= std::min(width_ - 1, u + 1) && highest; ++x) {
        highest = (above == nullptr || above[x] <= dot) && (below == nullptr || below[x] < dot);
      }
      if (!highest) continue;
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
  constexpr std::size_t places = 3;
  constexpr std::size_t most_ways = 3;
  constexpr float as_good = 0.8F;
  constexpr float promising = 0.6F;
  constexpr double other_angle = 20.0;  // degrees: nearer ones lead to the same pose
  const std::vector<Hypothesis>& tried = *task.hypotheses;
  more_.clear();
  const std::size_t looked_at = std::min(places, peaks_.size());
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

void CoarseSearch::run(const CoarseTask& task, ThreadPool& threads, std::vector<CoarseCandidate>& out) {
  out.clear();
  const Level& level = *task.projection.level;
  const std::vector<Hypothesis>& tried = *task.hypotheses;
  if (task.points->size() < 4 || tried.empty() || level.width < 1 || level.height < 1) return;
  prepare_copies(task);
  prepare_plane(level);
  windows_.clear();
  for (const Copy& copy : copies_) windows_.push_back(window_of(task, copy));
  const auto size = static_cast<std::size_t>(row_) * static_cast<std::size_t>(height_);
  best_.resize(size);
  which_.resize(size);
  const int workers = threads.size();
  threads.run([&](int worker) { first_pass(task, height_ * worker / workers, height_ * (worker + 1) / workers); });
  second_pass(task);
  other_ways(task);
  for (const Peak& peak : peaks_) {
    const std::size_t h = peak.hypothesis;
    const Eigen::Vector2d anchor(peak.u, peak.v);
    const Eigen::Vector2d plane =
        task.projection.mapping->plane_from_image(level.image_from_level(anchor + copies_[h].origin));
    out.push_back({{plane.x(), plane.y(), tried[h].angle_deg, tried[h].scale_x, tried[h].scale_y}, peak.score});
  }
}

}  // namespace vsfind
