#include "finder/search_points.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace vsfind {

namespace {

constexpr std::size_t most_points = 96;
constexpr std::size_t least_points = 24;
constexpr double radian = std::numbers::pi / 180.0;

/// One choice among the candidates, made from the views collected so far.
class Choice {
 public:
  Choice(const TrainingScene& scene, const SearchViews& views)
      : scene_(scene),
        views_(views),
        own_(views.genuine().size()),
        other_(views.impostors().size()),
        stranger_(views.strangers().size()),
        used_(views.size(), 0) {}

  /// Adds the point that keeps the pattern's own scores highest and all others lowest, until no point helps. Indices of
  /// candidates in the order of choice, an even number.
  std::vector<std::size_t> greedy() {
    const std::size_t n = views_.size();
    const std::vector<char>& telling_at = views_.telling();
    start();
    std::size_t telling = 0;
    for (const std::size_t k : chosen_) telling += telling_at[k] != 0 ? 1 : 0;
    double before = 0.0;
    double last_gain = 1.0;
    while (chosen_.size() < std::min(n, most_points)) {
      double best = -1e9;
      std::size_t which = n;
      // At least half of the points lie where the pattern differs from what it must be told from, if there is room.
      const bool half_telling = views_.telling_count() >= least_points / 2 && 2 * telling <= chosen_.size();
      for (std::size_t k = 0; k < n; ++k) {
        if (used_[k] != 0 || (half_telling && telling_at[k] == 0)) continue;
        const double quality = quality_with(k);
        if (quality > best) {
          best = quality;
          which = k;
        }
      }
      if (which == n) break;
      add(which);
      telling += telling_at[which] != 0 ? 1 : 0;
      last_gain = 0.8 * last_gain + 0.2 * std::max(0.0, best - before);
      before = best;
      constexpr double worth_a_point = 4e-4;
      if (chosen_.size() >= least_points && chosen_.size() % 2 == 0 && last_gain < worth_a_point) break;
    }
    if (chosen_.size() % 2 != 0) chosen_.pop_back();
    return chosen_;
  }

 private:
  void add(std::size_t k) {
    const float own_value = views_.values()[k];
    used_[k] = 1;
    chosen_.push_back(k);
    count_ += 1.0F;
    t_ += own_value;
    tt_ += own_value * own_value;
    const auto take = [&](std::vector<Sums>& sums, const Views& views) {
      for (std::size_t m = 0; m < sums.size(); ++m) {
        const float value = views[m][k];
        sums[m].i += value;
        sums[m].ii += value * value;
        sums[m].it += value * own_value;
      }
    };
    take(own_, views_.genuine());
    take(other_, views_.impostors());
    take(stranger_, views_.strangers());
  }

  /// A first handful: far apart, bright and dark by turns, little moved by the steps of the grid, and unlike what the
  /// pattern must be told from.
  void start() {
    const std::size_t n = views_.size();
    const std::vector<float>& values = views_.values();
    const Views& genuine = views_.genuine();
    std::vector<float> unrest(n, 0.0F);
    for (const std::vector<float>& view : genuine) {
      for (std::size_t k = 0; k < n; ++k) unrest[k] += (view[k] - values[k]) * (view[k] - values[k]);
    }
    std::vector<float> sorted = values;
    std::sort(sorted.begin(), sorted.end());
    const float middle = 0.5F * (sorted[n / 10] + sorted[n - 1 - n / 10]);
    const float preferred = sorted[n - 1] - sorted[0];
    for (int quarter = 0; quarter < 4; ++quarter) {
      for (const bool bright : {true, false}) {
        std::size_t which = n;
        float best = -1e9F;
        for (std::size_t k = 0; k < n; ++k) {
          const Eigen::Vector2d& at = views_.candidates()[k];
          const bool right = at.x() > scene_.left() + scene_.width() / 2.0;
          const bool lower = at.y() > scene_.top() + scene_.height() / 2.0;
          if ((right ? 1 : 0) + (lower ? 2 : 0) != quarter || used_[k] != 0) continue;
          const float contrast = bright ? values[k] - middle : middle - values[k];
          const float worth = contrast + (views_.telling()[k] != 0 ? preferred : 0.0F) -
                              2.0F * std::sqrt(unrest[k] / static_cast<float>(genuine.size()));
          if (worth > best) {
            best = worth;
            which = k;
          }
        }
        if (which != n) add(which);
      }
    }
  }

  [[nodiscard]] double quality_with(std::size_t k) const {
    const float value = views_.values()[k];
    const float n = count_ + 1.0F;
    const float new_t = t_ + value;
    const float new_tt = tt_ + value * value;
    const auto score = [&](const Sums& s, float seen) {
      return score_of(n, {s.i + seen, s.ii + seen * seen, s.it + seen * value}, new_t, new_tt);
    };
    // Fourth powers stand for the worst cases and stay smooth.
    float lost = 0.0F;
    const Views& genuine = views_.genuine();
    for (std::size_t m = 0; m < own_.size(); ++m) {
      const float miss = 1.0F - score(own_[m], genuine[m][k]);
      lost += miss * miss * miss * miss;
    }
    const auto taken = [&](const std::vector<Sums>& sums, const Views& views) {
      float sum = 0.0F;
      for (std::size_t m = 0; m < sums.size(); ++m) {
        const float like = std::max(0.0F, score(sums[m], views[m][k]));
        sum += like * like * like * like;
      }
      return sum;
    };
    const auto mean = [](float sum, std::size_t size) {
      return size == 0 ? 0.0 : std::sqrt(std::sqrt(static_cast<double>(sum) / static_cast<double>(size)));
    };
    // What the pattern must be told from counts for more than its own copies: somebody has asked for it.
    return -mean(lost, own_.size()) - mean(taken(other_, views_.impostors()), other_.size()) -
           2.0 * mean(taken(stranger_, views_.strangers()), stranger_.size());
  }

  const TrainingScene& scene_;
  const SearchViews& views_;
  // Over the points chosen so far: in each view, and of the pattern's own values.
  std::vector<Sums> own_;
  std::vector<Sums> other_;
  std::vector<Sums> stranger_;
  float count_ = 0.0F;
  float t_ = 0.0F;
  float tt_ = 0.0F;
  std::vector<char> used_;
  std::vector<std::size_t> chosen_;
};

/// How far apart the chosen points alone hold the pattern and everything else.
void measure(const SearchViews& views, const std::vector<std::size_t>& chosen, SearchPoints& result) {
  const std::vector<float>& values = views.values();
  const auto score = [&](const std::vector<float>& view) {
    Sums seen;
    float t = 0.0F;
    float tt = 0.0F;
    for (const std::size_t k : chosen) {
      seen.i += view[k];
      seen.ii += view[k] * view[k];
      seen.it += view[k] * values[k];
      t += values[k];
      tt += values[k] * values[k];
    }
    return static_cast<double>(score_of(static_cast<float>(chosen.size()), seen, t, tt));
  };
  result.worst_genuine = 1.0;
  result.best_impostor = 0.0;
  for (const std::vector<float>& view : views.genuine())
    result.worst_genuine = std::min(result.worst_genuine, score(view));
  for (const Views* others : {&views.impostors(), &views.strangers()}) {
    for (const std::vector<float>& view : *others) result.best_impostor = std::max(result.best_impostor, score(view));
  }
}

}  // namespace

CoarseGrid coarse_grid(const TrainingScene& scene, int level, const TrainOptions& options, double widening) {
  const double step = std::ldexp(1.0, level);
  // r.m.s. distances of a rectangle's points from its middle, level pixels.
  const double rms_x = scene.width() / step / std::sqrt(12.0);
  const double rms_y = scene.height() / step / std::sqrt(12.0);
  CoarseGrid grid;
  grid.angle_deg = options.angle_deg;
  grid.scale_x = options.scale_x;
  grid.scale_y = options.scale_y;
  grid.common_scale = options.common_scale;
  grid.angle_step_deg = std::min(30.0, widening / std::hypot(rms_x, rms_y) / radian);
  grid.scale_step = std::min(
      0.4, 0.8 * widening /
               (options.common_scale ? std::hypot(rms_x, rms_y) / std::numbers::sqrt2 : std::max(rms_x, rms_y)));
  return grid;
}

SearchPoints choose_search_points(TrainingScene& scene, int level, const TrainOptions& options,
                                  const std::vector<AgainstLevel>& against, double widening) {
  SearchPoints result;
  result.level = level;
  result.grid = coarse_grid(scene, level, options, widening);
  SearchViews views(scene, level, result.grid, against);
  if (views.size() < least_points) return result;
  views.collect_genuine();
  views.collect_own_copies();
  views.collect_strangers();
  std::vector<std::size_t> chosen = Choice(scene, views).greedy();
  // The second and third choice know what the one before mistook for the pattern.
  for (int round = 0; round < 2; ++round) {
    views.collect_impostors(chosen);
    chosen = Choice(scene, views).greedy();
  }
  measure(views, chosen, result);
  for (const std::size_t k : chosen) result.points.push_back(views.point(k));
  return result;
}

}  // namespace vsfind
