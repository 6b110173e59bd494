#include "finder/search_views.h"

#include <algorithm>
#include <array>
#include <memory>
#include <numbers>
#include <random>
#include <utility>

#include "finder/telling_places.h"

namespace vsfind {

namespace {

constexpr std::size_t most_candidates = 700;
constexpr double radian = std::numbers::pi / 180.0;

/// Repeatable numbers in −1 … 1, the same on every machine.
class Jitter {
 public:
  double next() { return static_cast<double>(random_() >> 11U) * 0x1.0p-52 - 1.0; }

 private:
  std::mt19937_64 random_{20240601};
};

struct Phase {
  Pyramid pyramid;
  Level level;  ///< smoothed
};

/// The same level as it would be had the camera stood a few pixels off: structure near the level's own resolution
/// looks different at each.
std::vector<std::unique_ptr<Phase>> phases_of(const TrainingScene& scene, int level_index, const Level& level) {
  std::vector<std::unique_ptr<Phase>> phases;
  constexpr std::array<std::pair<double, double>, 6> offsets{
      {{0.0, 0.0}, {0.5, 0.5}, {0.25, 0.75}, {0.75, 0.25}, {0.5, 0.0}, {0.0, 0.5}}};
  const ImageView& image = scene.image();
  for (const auto& [part_x, part_y] : offsets) {
    const int left = static_cast<int>(part_x * level.step_x);
    const int top = static_cast<int>(part_y * level.step_y);
    phases.push_back(std::make_unique<Phase>());
    Phase& phase = *phases.back();
    ImageView view = image;
    view.data += top * image.stride + left * static_cast<std::ptrdiff_t>(image.bits > 8 ? 2 : 1);
    view.width -= left;
    view.height -= top;
    phase.pyramid.build(view, scene.plan());
    if (level_index >= phase.pyramid.levels()) {
      phases.pop_back();
      continue;
    }
    phase.level = phase.pyramid.smoothed(level_index);
    phase.level.offset_x += left;
    phase.level.offset_y += top;
  }
  return phases;
}

}  // namespace

SearchViews::SearchViews(TrainingScene& scene, int level, const CoarseGrid& grid,
                         const std::vector<AgainstLevel>& against)
    : scene_(scene),
      against_(against),
      grid_(grid),
      level_index_(level),
      level_(scene.pyramid().smoothed(level)),
      step_(std::ldexp(1.0, level)),
      candidates_(scene.lattice(step_, step_ / 2.0 - 1e-6)) {
  thin_out();
  values_ = read(level_, scene_.mapping(), scene_.pose());
  drop_unread();
}

void SearchViews::thin_out() {
  if (candidates_.size() <= most_candidates) return;
  std::vector<Eigen::Vector2d> kept;
  const double every = static_cast<double>(candidates_.size()) / static_cast<double>(most_candidates);
  for (double at = 0.0; at < static_cast<double>(candidates_.size()); at += every) {
    kept.push_back(candidates_[static_cast<std::size_t>(at)]);
  }
  candidates_ = kept;
}

PatternPoint SearchViews::point(std::size_t k) const {
  PatternPoint p;
  p.x = candidates_[k].x();
  p.y = candidates_[k].y();
  p.value = values_[k];
  return p;
}

std::vector<float> SearchViews::read(const Level& level, const Mapping& mapping, const Pose& pose) const {
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

void SearchViews::drop_unread() {
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

void SearchViews::collect_genuine() {
  const std::vector<std::unique_ptr<Phase>> phases = phases_of(scene_, level_index_, level_);
  Jitter jitter;
  constexpr int situations = 48;
  const double half_angle = grid_.angle_deg.searched() ? grid_.angle_step_deg / 2.0 : 0.0;
  const double half_x = grid_.scale_x.searched() ? grid_.scale_step / 2.0 : 0.0;
  const double half_y = grid_.scale_y.searched() ? grid_.scale_step / 2.0 : 0.0;
  const std::size_t n = candidates_.size();
  std::vector<double> u(n), v(n), value(n), inside(n);
  const Pose& pose = scene_.pose();
  std::vector<double> x(n), y(n);
  for (int m = 0; m < situations; ++m) {
    const Level& level = phases[static_cast<std::size_t>(m) % phases.size()]->level;
    const Projection projection{&scene_.mapping(), &level, scene_.pitch()};
    // The first ones are the corners of the cell, where it is worst.
    const auto at = [&](int bit) { return m < 16 ? ((m >> bit & 1) != 0 ? 1.0 : -1.0) : jitter.next(); };
    const double dx = 0.5 * step_ * at(0);
    const double dy = 0.5 * step_ * at(1);
    const double turn = half_angle * at(2) * radian;
    const double grow_x = half_x * at(3);
    const double grow_y = grid_.common_scale ? grow_x : half_y * (m < 16 ? at(3) : jitter.next());
    const double seen = (grid_.angle_deg.min + grid_.angle_deg.width() * 0.5 * (1.0 + jitter.next())) * radian;
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

void SearchViews::collect_own_copies() {
  for (const double reach : {2.0, 3.0, 5.0}) {
    for (int direction = 0; direction < 8; ++direction) {
      const double a = direction * std::numbers::pi / 4.0;
      Pose pose = scene_.pose();
      pose.x += scene_.pitch() * step_ * reach * std::cos(a);
      pose.y += scene_.pitch() * step_ * reach * std::sin(a);
      add_impostor(level_, scene_.mapping(), pose, impostors_);
    }
  }
  if (grid_.angle_deg.searched()) {
    for (const double steps : {-3.0, -2.0, 2.0, 3.0}) {
      Pose pose = scene_.pose();
      pose.angle_deg += steps * grid_.angle_step_deg;
      add_impostor(level_, scene_.mapping(), pose, impostors_);
    }
  }
}

void SearchViews::collect_strangers() {
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
  telling_count_ = static_cast<std::size_t>(std::count(telling_.begin(), telling_.end(), 1));
}

void SearchViews::collect_impostors(const std::vector<std::size_t>& chosen) {
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

std::vector<float> SearchViews::whole(std::vector<float> view) const {
  float mean = 0.0F;
  for (const float value : values_) mean += value;
  mean /= static_cast<float>(values_.size());
  for (float& value : view) {
    if (std::isnan(value)) value = mean;
  }
  return view;
}

float SearchViews::whole_score(const std::vector<float>& view) const {
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
  return score_of(static_cast<float>(view.size()), seen, t, tt);
}

void SearchViews::add_impostor(const Level& level, const Mapping& mapping, const Pose& pose, Views& views) const {
  std::vector<float> view = whole(read(level, mapping, pose));
  // What all points together cannot tell from the pattern, no choice of points will.
  constexpr float hopeless = 0.9F;
  if (whole_score(view) < hopeless) views.push_back(std::move(view));
}

std::vector<CoarseCandidate> SearchViews::look_for(const std::vector<std::size_t>& chosen, const Level& level,
                                                   const Mapping& mapping) const {
  std::vector<PatternPoint> points;
  points.reserve(chosen.size());
  for (const std::size_t k : chosen) points.push_back(point(k));
  const CoarsePoints coarse(points);
  const std::vector<Hypothesis> tried = hypotheses(grid_);
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

std::vector<float> SearchViews::likest(const AgainstLevel& other, const std::vector<CoarseCandidate>& found) const {
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

}  // namespace vsfind
