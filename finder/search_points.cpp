#include "finder/search_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>

#include "finder/coarse_search.h"
#include "finder/telling_places.h"

namespace vsfind {

namespace {

constexpr std::size_t most_candidates = 700;
constexpr std::size_t most_points = 96;
constexpr std::size_t least_points = 24;
constexpr double radian = std::numbers::pi / 180.0;

/// Values that all candidate points read in one situation, row by row.
using Views = std::vector<std::vector<float>>;

/// Running sums of one situation over the points chosen so far.
struct Sums {
  float i = 0.0F;
  float ii = 0.0F;
  float it = 0.0F;
};

float score_of(float n, float i, float ii, float it, float t, float tt) {
  const float vi = n * ii - i * i;
  const float vt = n * tt - t * t;
  if (vi < n * n || vt < n * n) return 0.0F;
  return (n * it - i * t) / std::sqrt(vi * vt);
}

/// Repeatable numbers in −1 … 1, the same on every machine.
class Jitter {
 public:
  double next() { return static_cast<double>(random_() >> 11U) * 0x1.0p-52 - 1.0; }

 private:
  std::mt19937_64 random_{20240601};
};

class Chooser {
 public:
  Chooser(TrainingScene& scene, int level_index, const TrainOptions& options, const std::vector<AgainstLevel>& against,
          double widening)
      : scene_(scene), against_(against), level_(scene.pyramid().smoothed(level_index)) {
    result_.level = level_index;
    result_.grid = coarse_grid(scene, level_index, options, widening);
    step_ = std::ldexp(1.0, level_index);
    make_phases(level_index);
  }

  SearchPoints choose() {
    candidates_ = scene_.lattice(step_, step_ / 2.0 - 1e-6);
    thin_out();
    if (candidates_.size() < least_points) return result_;
    values_ = read(level_, scene_.mapping(), scene_.pose());
    drop_unread();
    if (candidates_.size() < least_points) return result_;
    collect_genuine();
    own_copies();
    collect_strangers();
    std::vector<std::size_t> chosen = greedy();
    // The second and third choice know what the one before mistook for the pattern.
    for (int round = 0; round < 2; ++round) {
      collect_impostors(chosen);
      chosen = greedy();
    }
    result_.points.clear();
    for (const std::size_t k : chosen) result_.points.push_back(point(k));
    return result_;
  }

 private:
  /// The same level as it would be had the camera stood a few pixels off: structure near the level's own resolution
  /// looks different at each.
  void make_phases(int level_index) {
    constexpr std::array<std::pair<double, double>, 6> offsets{
        {{0.0, 0.0}, {0.5, 0.5}, {0.25, 0.75}, {0.75, 0.25}, {0.5, 0.0}, {0.0, 0.5}}};
    const ImageView& image = scene_.image();
    for (const auto& [part_x, part_y] : offsets) {
      const int left = static_cast<int>(part_x * level_.step_x);
      const int top = static_cast<int>(part_y * level_.step_y);
      phases_.push_back(std::make_unique<Phase>());
      Phase& phase = *phases_.back();
      ImageView view = image;
      view.data += top * image.stride + left * static_cast<std::ptrdiff_t>(image.bits > 8 ? 2 : 1);
      view.width -= left;
      view.height -= top;
      phase.pyramid.build(view, scene_.plan());
      if (level_index >= phase.pyramid.levels()) {
        phases_.pop_back();
        continue;
      }
      phase.level = phase.pyramid.smoothed(level_index);
      phase.level.offset_x += left;
      phase.level.offset_y += top;
    }
  }

  void thin_out() {
    if (candidates_.size() <= most_candidates) return;
    std::vector<Eigen::Vector2d> kept;
    const double every = static_cast<double>(candidates_.size()) / static_cast<double>(most_candidates);
    for (double at = 0.0; at < static_cast<double>(candidates_.size()); at += every) {
      kept.push_back(candidates_[static_cast<std::size_t>(at)]);
    }
    candidates_ = kept;
  }

  [[nodiscard]] PatternPoint point(std::size_t k) const {
    PatternPoint p;
    p.x = candidates_[k].x();
    p.y = candidates_[k].y();
    p.value = values_[k];
    return p;
  }

  /// What the candidates would read of a level picture at a pose; points outside read NaN.
  [[nodiscard]] std::vector<float> read(const Level& level, const Mapping& mapping, const Pose& pose) const {
    const std::size_t n = candidates_.size();
    std::vector<double> x(n), y(n), u(n), v(n), value(n), inside(n);
    for (std::size_t k = 0; k < n; ++k) {
      x[k] = candidates_[k].x();
      y[k] = candidates_[k].y();
    }
    const Projection projection{&mapping, &level, scene_.pitch()};
    projection.level_from_pattern(pose, x.data(), y.data(), static_cast<int>(n), u.data(), v.data());
    BilinearReader(level).read(u.data(), v.data(), static_cast<int>(n), value.data(), inside.data());
    std::vector<float> out(n);
    for (std::size_t k = 0; k < n; ++k) {
      out[k] = inside[k] > 0.0 ? static_cast<float>(value[k]) : std::nanf("");
    }
    return out;
  }

  void drop_unread() {
    std::vector<Eigen::Vector2d> kept;
    std::vector<float> values;
    for (std::size_t k = 0; k < candidates_.size(); ++k) {
      if (std::isnan(values_[k])) continue;
      kept.push_back(candidates_[k]);
      values.push_back(values_[k]);
    }
    candidates_ = kept;
    values_ = values;
  }

  /// The pattern itself as the coarse search meets it: anywhere within a cell of the grid, offsets rounded to whole
  /// pixels.
  void collect_genuine() {
    Jitter jitter;
    constexpr int situations = 48;
    const CoarseGrid& grid = result_.grid;
    const double half_angle = grid.angle_deg.searched() ? grid.angle_step_deg / 2.0 : 0.0;
    const double half_x = grid.scale_x.searched() ? grid.scale_step / 2.0 : 0.0;
    const double half_y = grid.scale_y.searched() ? grid.scale_step / 2.0 : 0.0;
    const std::size_t n = candidates_.size();
    std::vector<double> u(n), v(n), value(n), inside(n);
    const Pose& pose = scene_.pose();
    std::vector<double> x(n), y(n);
    for (int m = 0; m < situations; ++m) {
      const Level& level = phases_[static_cast<std::size_t>(m) % phases_.size()]->level;
      const Projection projection{&scene_.mapping(), &level, scene_.pitch()};
      // The first ones are the corners of the cell, where it is worst.
      const auto at = [&](int bit) { return m < 16 ? ((m >> bit & 1) != 0 ? 1.0 : -1.0) : jitter.next(); };
      const double dx = 0.5 * step_ * at(0);
      const double dy = 0.5 * step_ * at(1);
      const double turn = half_angle * at(2) * radian;
      const double grow_x = half_x * at(3);
      const double grow_y = grid.common_scale ? grow_x : half_y * (m < 16 ? at(3) : jitter.next());
      const double seen = (grid.angle_deg.min + grid.angle_deg.width() * 0.5 * (1.0 + jitter.next())) * radian;
      for (std::size_t k = 0; k < n; ++k) {
        // Rounding to whole pixels happens in the searched picture, whose axes are turned by `seen`.
        const double px = candidates_[k].x() / step_;
        const double py = candidates_[k].y() / step_;
        const double rx = std::cos(seen) * px - std::sin(seen) * py;
        const double ry = std::sin(seen) * px + std::cos(seen) * py;
        const double ex = std::round(rx) - rx;
        const double ey = std::round(ry) - ry;
        const double qx = candidates_[k].x() + step_ * (std::cos(seen) * ex + std::sin(seen) * ey);
        const double qy = candidates_[k].y() + step_ * (std::cos(seen) * ey - std::sin(seen) * ex);
        x[k] = (1.0 + grow_x) * (std::cos(turn) * qx - std::sin(turn) * qy) + dx;
        y[k] = (1.0 + grow_y) * (std::sin(turn) * qx + std::cos(turn) * qy) + dy;
      }
      projection.level_from_pattern(pose, x.data(), y.data(), static_cast<int>(n), u.data(), v.data());
      BilinearReader(level).read(u.data(), v.data(), static_cast<int>(n), value.data(), inside.data());
      std::vector<float> view(n);
      for (std::size_t k = 0; k < n; ++k) view[k] = inside[k] > 0.0 ? static_cast<float>(value[k]) : values_[k];
      genuine_.push_back(std::move(view));
    }
  }

  /// The pattern's own copies, shifted and turned by more than a cell.
  void own_copies() {
    for (const double reach : {2.0, 3.0, 5.0}) {
      for (int direction = 0; direction < 8; ++direction) {
        const double a = direction * std::numbers::pi / 4.0;
        Pose pose = scene_.pose();
        pose.x += scene_.pitch() * step_ * reach * std::cos(a);
        pose.y += scene_.pitch() * step_ * reach * std::sin(a);
        add_impostor(level_, scene_.mapping(), pose, impostors_);
      }
    }
    const CoarseGrid& grid = result_.grid;
    if (grid.angle_deg.searched()) {
      for (const double steps : {-3.0, -2.0, 2.0, 3.0}) {
        Pose pose = scene_.pose();
        pose.angle_deg += steps * grid.angle_step_deg;
        add_impostor(level_, scene_.mapping(), pose, impostors_);
      }
    }
  }

  /// Outside the picture nobody knows what there is: the pattern's own mean is neutral.
  [[nodiscard]] std::vector<float> whole(std::vector<float> view) const {
    float mean = 0.0F;
    for (const float value : values_) mean += value;
    mean /= static_cast<float>(values_.size());
    for (float& value : view) {
      if (std::isnan(value)) value = mean;
    }
    return view;
  }

  /// Of all candidates together.
  [[nodiscard]] float whole_score(const std::vector<float>& view) const {
    Sums seen;
    float t = 0.0F;
    float tt = 0.0F;
    for (std::size_t k = 0; k < view.size(); ++k) {
      seen.i += view[k];
      seen.ii += view[k] * view[k];
      seen.it += view[k] * values_[k];
      t += values_[k];
      tt += values_[k] * values_[k];
    }
    return score_of(static_cast<float>(view.size()), seen.i, seen.ii, seen.it, t, tt);
  }

  void add_impostor(const Level& level, const Mapping& mapping, const Pose& pose, Views& views) {
    std::vector<float> view = whole(read(level, mapping, pose));
    // What all points together cannot tell from the pattern, no choice of points will.
    constexpr float hopeless = 0.9F;
    if (whole_score(view) < hopeless) views.push_back(std::move(view));
  }

  /// What looks like the pattern in the scenes to tell it from, to points from all over it: the choice has not begun.
  void collect_strangers() {
    telling_.assign(candidates_.size(), 0);
    std::vector<std::size_t> all_over;
    const std::size_t most = std::min<std::size_t>(candidates_.size(), most_coarse_points) / 2 * 2;
    for (std::size_t i = 0; i < most; ++i) all_over.push_back(i * candidates_.size() / most);
    for (const AgainstLevel& other : against_) {
      const std::vector<CoarseCandidate> found = look_for(all_over, other.level, other.mapping);
      for (const CoarseCandidate& each : found) add_impostor(other.level, other.mapping, each.pose, strangers_);
      if (found.empty()) continue;
      const std::vector<char> telling = telling_places(values_, likest(other, found));
      for (std::size_t k = 0; k < telling_.size(); ++k) telling_[k] = std::max(telling_[k], telling[k]);
    }
    telling_places_ = static_cast<std::size_t>(std::count(telling_.begin(), telling_.end(), 1));
  }

  /// The view of another scene that all candidates together take for the pattern most: uphill from the best few.
  [[nodiscard]] std::vector<float> likest(const AgainstLevel& other, const std::vector<CoarseCandidate>& found) const {
    std::vector<float> best;
    float best_score = -2.0F;
    constexpr std::size_t few = 8;
    for (std::size_t i = 0; i < std::min(few, found.size()); ++i) {
      Pose pose = found[i].pose;
      std::vector<float> view = whole(read(other.level, other.mapping, pose));
      float score = whole_score(view);
      for (double shift = scene_.pitch() * step_ / 2.0; shift > scene_.pitch() * step_ / 10.0;) {
        bool better = false;
        for (const auto& [dx, dy] : {std::pair(shift, 0.0), {-shift, 0.0}, {0.0, shift}, {0.0, -shift}}) {
          Pose moved = pose;
          moved.x += dx;
          moved.y += dy;
          std::vector<float> seen = whole(read(other.level, other.mapping, moved));
          const float then = whole_score(seen);
          if (then <= score) continue;
          better = true;
          score = then;
          pose = moved;
          view = std::move(seen);
        }
        if (!better) shift /= 2.0;
      }
      if (score > best_score) {
        best_score = score;
        best = std::move(view);
      }
    }
    return best;
  }

  [[nodiscard]] std::vector<CoarseCandidate> look_for(const std::vector<std::size_t>& chosen, const Level& level,
                                                      const Mapping& mapping) const {
    std::vector<PatternPoint> points;
    points.reserve(chosen.size());
    for (const std::size_t k : chosen) points.push_back(point(k));
    const CoarsePoints coarse(points);
    const std::vector<Hypothesis> tried = hypotheses(result_.grid);
    ThreadPool here(1);
    CoarseSearch search;
    CoarseTask task;
    task.points = &coarse;
    task.hypotheses = &tried;
    task.projection = {&mapping, &level, scene_.pitch()};
    task.threshold = 0.3F;
    task.min_inside = 0.8F;
    task.most = 150;
    std::vector<CoarseCandidate> found;
    search.run(task, here, found);
    return found;
  }

  /// What the points chosen so far mistake for the pattern, in the training scene and the scenes to tell it from.
  void collect_impostors(const std::vector<std::size_t>& chosen) {
    for (const CoarseCandidate& candidate : look_for(chosen, level_, scene_.mapping())) {
      const double away =
          std::hypot(candidate.pose.x - scene_.pose().x, candidate.pose.y - scene_.pose().y) / (scene_.pitch() * step_);
      if (away >= 2.5) add_impostor(level_, scene_.mapping(), candidate.pose, impostors_);
    }
    for (const AgainstLevel& other : against_) {
      for (const CoarseCandidate& candidate : look_for(chosen, other.level, other.mapping)) {
        add_impostor(other.level, other.mapping, candidate.pose, strangers_);
      }
    }
  }

  /// Adds the point that keeps the pattern's own scores highest and all others lowest, until no point helps.
  std::vector<std::size_t> greedy() {
    const std::size_t n = candidates_.size();
    std::vector<Sums> own(genuine_.size());
    std::vector<Sums> other(impostors_.size());
    std::vector<Sums> stranger(strangers_.size());
    std::vector<std::size_t> chosen;
    std::vector<char> used(n, 0);
    float count = 0.0F;
    float t = 0.0F;
    float tt = 0.0F;
    const auto add = [&](std::size_t k) {
      used[k] = 1;
      chosen.push_back(k);
      count += 1.0F;
      t += values_[k];
      tt += values_[k] * values_[k];
      const auto take = [&](std::vector<Sums>& sums, const Views& views) {
        for (std::size_t m = 0; m < sums.size(); ++m) {
          const float value = views[m][k];
          sums[m].i += value;
          sums[m].ii += value * value;
          sums[m].it += value * values_[k];
        }
      };
      take(own, genuine_);
      take(other, impostors_);
      take(stranger, strangers_);
    };
    start(add, used);
    std::size_t telling = 0;
    for (const std::size_t k : chosen) telling += telling_[k] != 0 ? 1 : 0;
    double before = 0.0;
    double last_gain = 1.0;
    while (chosen.size() < std::min(n, most_points)) {
      double best = -1e9;
      std::size_t which = n;
      // At least half of the points lie where the pattern differs from what it must be told from, if there is room.
      const bool half_telling = telling_places_ >= least_points / 2 && 2 * telling <= chosen.size();
      for (std::size_t k = 0; k < n; ++k) {
        if (used[k] != 0 || (half_telling && telling_[k] == 0)) continue;
        const double quality = quality_with(k, count, t, tt, own, other, stranger);
        if (quality > best) {
          best = quality;
          which = k;
        }
      }
      if (which == n) break;
      add(which);
      telling += telling_[which] != 0 ? 1 : 0;
      last_gain = 0.8 * last_gain + 0.2 * std::max(0.0, best - before);
      before = best;
      constexpr double worth_a_point = 4e-4;
      if (chosen.size() >= least_points && chosen.size() % 2 == 0 && last_gain < worth_a_point) break;
    }
    if (chosen.size() % 2 != 0) chosen.pop_back();
    measure(chosen);
    return chosen;
  }

  /// A first handful: far apart, bright and dark by turns, little moved by the steps of the grid, and unlike what the
  /// pattern must be told from.
  template <typename Add>
  void start(Add add, const std::vector<char>& used) {
    const std::size_t n = candidates_.size();
    std::vector<float> unrest(n, 0.0F);
    for (const std::vector<float>& view : genuine_) {
      for (std::size_t k = 0; k < n; ++k) unrest[k] += (view[k] - values_[k]) * (view[k] - values_[k]);
    }
    std::vector<float> sorted = values_;
    std::sort(sorted.begin(), sorted.end());
    const float middle = 0.5F * (sorted[n / 10] + sorted[n - 1 - n / 10]);
    const float preferred = sorted[n - 1] - sorted[0];
    for (int quarter = 0; quarter < 4; ++quarter) {
      for (const bool bright : {true, false}) {
        std::size_t which = n;
        float best = -1e9F;
        for (std::size_t k = 0; k < n; ++k) {
          const bool right = candidates_[k].x() > scene_.left() + scene_.width() / 2.0;
          const bool lower = candidates_[k].y() > scene_.top() + scene_.height() / 2.0;
          if ((right ? 1 : 0) + (lower ? 2 : 0) != quarter || used[k] != 0) continue;
          const float contrast = bright ? values_[k] - middle : middle - values_[k];
          const float worth = contrast + (telling_[k] != 0 ? preferred : 0.0F) -
                              2.0F * std::sqrt(unrest[k] / static_cast<float>(genuine_.size()));
          if (worth > best) {
            best = worth;
            which = k;
          }
        }
        if (which != n) add(which);
      }
    }
  }

  [[nodiscard]] double quality_with(std::size_t k, float count, float t, float tt, const std::vector<Sums>& own,
                                    const std::vector<Sums>& other, const std::vector<Sums>& stranger) const {
    const float value = values_[k];
    const float n = count + 1.0F;
    const float new_t = t + value;
    const float new_tt = tt + value * value;
    const auto score = [&](const Sums& s, float seen) {
      return score_of(n, s.i + seen, s.ii + seen * seen, s.it + seen * value, new_t, new_tt);
    };
    // Fourth powers stand for the worst cases and stay smooth.
    float lost = 0.0F;
    for (std::size_t m = 0; m < own.size(); ++m) {
      const float miss = 1.0F - score(own[m], genuine_[m][k]);
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
    return -mean(lost, own.size()) - mean(taken(other, impostors_), other.size()) -
           2.0 * mean(taken(stranger, strangers_), stranger.size());
  }

  void measure(const std::vector<std::size_t>& chosen) {
    const auto score = [&](const std::vector<float>& view) {
      float i = 0.0F;
      float ii = 0.0F;
      float it = 0.0F;
      float t = 0.0F;
      float tt = 0.0F;
      for (const std::size_t k : chosen) {
        i += view[k];
        ii += view[k] * view[k];
        it += view[k] * values_[k];
        t += values_[k];
        tt += values_[k] * values_[k];
      }
      return static_cast<double>(score_of(static_cast<float>(chosen.size()), i, ii, it, t, tt));
    };
    result_.worst_genuine = 1.0;
    result_.best_impostor = 0.0;
    for (const std::vector<float>& view : genuine_)
      result_.worst_genuine = std::min(result_.worst_genuine, score(view));
    for (const Views* views : {&impostors_, &strangers_}) {
      for (const std::vector<float>& view : *views)
        result_.best_impostor = std::max(result_.best_impostor, score(view));
    }
  }

  const TrainingScene& scene_;
  const std::vector<AgainstLevel>& against_;
  Level level_;  // smoothed
  struct Phase {
    Pyramid pyramid;
    Level level;
  };
  std::vector<std::unique_ptr<Phase>> phases_;
  double step_ = 1.0;
  std::vector<Eigen::Vector2d> candidates_;
  std::vector<float> values_;
  Views genuine_;
  Views impostors_;
  Views strangers_;            ///< from the scenes to tell the pattern from
  std::vector<char> telling_;  ///< the candidates that tell the pattern from the likest of them
  std::size_t telling_places_ = 0;
  SearchPoints result_;
};

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
  return Chooser(scene, level, options, against, widening).choose();
}

}  // namespace vsfind
