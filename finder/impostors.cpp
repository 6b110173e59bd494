#include "finder/impostors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "finder/prepared_pattern.h"

namespace vsfind {

namespace {

constexpr double degrees = 180.0 / std::numbers::pi;
/// From this score on something may be taken for the pattern.
constexpr double alike = 0.8;
/// Scores nearer than this are as good as equal.
constexpr double as_good = 0.03;

bool is_turned(const Impostor& impostor, const Pattern& pattern) {
  constexpr double same_place = 0.1;  // of the pattern's size
  return impostor.scene < 0 && impostor.shift.norm() < same_place * std::min(pattern.width, pattern.height) &&
         std::abs(impostor.turn_deg) > 1.0;
}

class Measuring {
 public:
  Measuring(TrainingScene& scene, const Pattern& pattern)
      : scene_(scene),
        pattern_(pattern),
        // Nobody owns it: the pattern outlives this object.
        prepared_(std::shared_ptr<const Pattern>(std::shared_ptr<void>(), &pattern), {}),
        middle_(pattern.left + pattern.width / 2.0, pattern.top + pattern.height / 2.0) {}

  void in_scene(const ImageView& image, Pyramid& pyramid, int index, std::vector<Impostor>& found) {
    if (pattern_.top_level >= pyramid.levels()) return;
    constexpr std::size_t most = 48;
    CoarseTask task;
    task.points = &prepared_.search;
    task.hypotheses = &prepared_.hypotheses;
    task.projection = projection(pyramid.smoothed(pattern_.top_level));
    task.polarity = pattern_.polarity;
    task.threshold = 0.3F;
    task.min_inside = static_cast<float>(least_inside);
    task.most = most;
    std::vector<CoarseCandidate> candidates;
    ThreadPool here(1);
    coarse_.run(task, here, candidates);
    for (const CoarseCandidate& candidate : candidates) add(image, pyramid, candidate.pose, index, found);
  }

  /// The pattern over itself at every shift up to its own size and some more, as a grid repeats: the exhaustive search
  /// keeps only the best of very many such places.
  void shifted(std::vector<Impostor>& found) {
    const Level& level = scene_.pyramid().smoothed(pattern_.top_level);
    const BilinearReader reader(level);
    const double pixel = std::ldexp(pattern_.pitch, pattern_.top_level);
    constexpr double reach = 1.25;  // of the pattern's size
    constexpr int most = 40;        // steps either way
    const int steps_x = std::min(most, static_cast<int>(reach * pattern_.width * pattern_.pitch / pixel));
    const int steps_y = std::min(most, static_cast<int>(reach * pattern_.height * pattern_.pitch / pixel));
    const int columns = 2 * steps_x + 1;
    const int rows = 2 * steps_y + 1;
    const auto pose_at = [&](int c, int r) {
      Pose pose = scene_.pose();
      pose.x += (c - steps_x) * pixel;
      pose.y += (r - steps_y) * pixel;
      return pose;
    };
    std::vector<double> scores;
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < columns; ++c) {
        double inside = 0.0;
        const double score = oriented(
            fit_.correlation(prepared_.climb, projection(level), reader, pose_at(c, r), inside), pattern_.polarity);
        scores.push_back(inside >= least_inside ? score : 0.0);
      }
    }
    const auto score_at = [&](int c, int r) {
      return scores[static_cast<std::size_t>(r) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(c)];
    };
    const auto is_peak = [&](int c, int r) {
      for (int y = std::max(0, r - 1); y <= std::min(rows - 1, r + 1); ++y) {
        for (int x = std::max(0, c - 1); x <= std::min(columns - 1, c + 1); ++x) {
          if (score_at(x, y) > score_at(c, r)) return false;
        }
      }
      return true;
    };
    std::vector<std::pair<double, Pose>> peaks;
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < columns; ++c) {
        constexpr double worth_a_look = 0.5;
        if (score_at(c, r) >= worth_a_look && is_peak(c, r)) {
          peaks.emplace_back(std::hypot(c - steps_x, r - steps_y), pose_at(c, r));
        }
      }
    }
    // The nearest tell the period.
    constexpr std::size_t nearest = 24;
    std::stable_sort(peaks.begin(), peaks.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (std::size_t i = 0; i < std::min(nearest, peaks.size()); ++i) {
      add(scene_.image(), scene_.pyramid(), peaks[i].second, -1, found);
    }
  }

  /// The pattern turned about its middle, as far as two angles of the range are apart.
  void turned(std::vector<Impostor>& found) {
    const double step = pattern_.angle_step_deg;
    if (!prepared_.freedom.angle || step <= 0.0) return;
    const double reach = std::min(180.0, pattern_.angle_deg.width());
    const int steps = static_cast<int>(std::floor(reach / step));
    const Level& level = scene_.pyramid().smoothed(pattern_.top_level);
    const BilinearReader reader(level);
    std::vector<double> scores;
    for (int i = -steps; i <= steps; ++i) {
      double inside = 0.0;
      scores.push_back(
          oriented(fit_.correlation(prepared_.climb, projection(level), reader, turned_by(i * step), inside),
                   pattern_.polarity));
    }
    for (std::size_t at = 0; at < scores.size(); ++at) {
      const int i = static_cast<int>(at) - steps;
      const double before = at > 0 ? scores[at - 1] : -1.0;
      const double after = at + 1 < scores.size() ? scores[at + 1] : -1.0;
      constexpr double worth_a_look = 0.3;
      constexpr double no_less = 0.9;  // a disc has no peaks
      const bool peak = scores[at] >= before && scores[at] >= after;
      if (scores[at] < worth_a_look || (!peak && scores[at] < no_less)) continue;
      add(scene_.image(), scene_.pyramid(), turned_by(i * step), -1, found);
    }
  }

 private:
  static constexpr double least_inside = 0.6;  ///< part of the pattern that must lie in the picture

  [[nodiscard]] Projection projection(const Level& level) const { return {&scene_.mapping(), &level, pattern_.pitch}; }
  [[nodiscard]] Eigen::Vector2d middle_at(const Pose& pose) const {
    return plane_from_pattern(pose, middle_ * pattern_.pitch);
  }
  [[nodiscard]] Pose turned_by(double turn) const {
    Pose pose = scene_.pose();
    const Eigen::Vector2d before = middle_at(pose);
    pose.angle_deg += turn;
    const Eigen::Vector2d after = middle_at(pose);
    pose.x += before.x() - after.x();
    pose.y += before.y() - after.y();
    return pose;
  }

  /// Down to full resolution as the search goes, without its suspicion against points that disagree.
  double settle(const ImageView& image, Pyramid& pyramid, Pose& pose) {
    FitOptions options;
    options.freedom = prepared_.freedom;
    options.robust = false;
    options.iterations = 6;
    options.polarity = pattern_.polarity;
    for (int index = pattern_.top_level; index >= (pattern_.top_level == 0 ? 0 : 1); --index) {
      const Level& level = pyramid.level(index);
      Pose moved = pose;
      const FitResult fit = fit_.fit(prepared_.follow[static_cast<std::size_t>(index)], projection(level),
                                     SmoothingReader(level), options, moved);
      constexpr double furthest = 4.0;  // level pixels
      if (fit.ok && std::hypot(moved.x - pose.x, moved.y - pose.y) <= std::ldexp(furthest * pattern_.pitch, index)) {
        pose = moved;
      }
    }
    const Eigen::Vector2d at = scene_.mapping().image_from_plane({pose.x, pose.y});
    if (!at.allFinite()) return 0.0;
    const GaussianReader reader = gaussian_reader(image, scene_.mapping(), at, pattern_.pitch, 1.0);
    const Level& level = pyramid.level(0);
    double inside = 0.0;
    double score =
        oriented(fit_.correlation(prepared_.verify, projection(level), reader, pose, inside), pattern_.polarity);
    Pose moved = pose;
    if (fit_.fit(prepared_.verify, projection(level), reader, options, moved).ok) {
      double inside_then = 0.0;
      const double then = oriented(fit_.correlation(prepared_.verify, projection(level), reader, moved, inside_then),
                                   pattern_.polarity);
      if (then > score) {
        score = then;
        inside = inside_then;
        pose = moved;
      }
    }
    return inside >= least_inside ? std::clamp(score, 0.0, 1.0) : 0.0;
  }

  void add(const ImageView& image, Pyramid& pyramid, Pose pose, int index, std::vector<Impostor>& found) {
    Impostor impostor;
    impostor.score = settle(image, pyramid, pose);
    impostor.scene = index;
    impostor.shift = (middle_at(pose) - middle_at(scene_.pose())) / pattern_.pitch;
    impostor.turn_deg = std::remainder(pose.angle_deg - scene_.pose().angle_deg, 360.0);
    impostor.image = scene_.mapping().image_from_plane(middle_at(pose));
    if (impostor.score <= 0.0 || !impostor.image.allFinite()) return;
    // The pattern itself, or the slope up to it.
    const double near = std::ldexp(1.5, pattern_.top_level);
    const bool itself = index < 0 && impostor.shift.norm() < near &&
                        std::abs(impostor.turn_deg) <= std::max(1.0, 1.5 * pattern_.angle_step_deg);
    // What only the two ends of the range have in common is no ambiguity.
    const double range = pattern_.angle_deg.width();
    const bool at_ends = range < 359.0 && std::abs(impostor.turn_deg) > range - 0.5 * pattern_.angle_step_deg;
    const bool ends = at_ends && index < 0 && is_turned(impostor, pattern_);
    if (!itself && !ends) found.push_back(impostor);
  }

  TrainingScene& scene_;
  const Pattern& pattern_;
  PreparedPattern prepared_;
  Eigen::Vector2d middle_;
  CoarseSearch coarse_;
  PoseFit fit_;
};

/// The pattern again, as it is, near enough to be the next one of a row.
bool is_period(const Impostor& impostor, const Pattern& pattern) {
  constexpr double straight = 2.0;    // degrees
  constexpr double neighbour = 1.75;  // of the pattern's size
  return impostor.scene < 0 && !is_turned(impostor, pattern) && std::abs(impostor.turn_deg) < straight &&
         impostor.shift.norm() < neighbour * std::hypot(pattern.width, pattern.height) / std::numbers::sqrt2;
}

double direction_of(const Impostor& impostor) {
  return std::fmod(std::atan2(impostor.shift.y(), impostor.shift.x()) * degrees + 360.0, 180.0);
}

std::string place_text(const Impostor& impostor) {
  return fmt::format("at {:.1f}, {:.1f} of {}", impostor.image.x(), impostor.image.y(),
                     impostor.scene < 0 ? std::string("the training picture")
                                        : fmt::format("scene {} of those to tell it from", impostor.scene + 1));
}

/// The smallest turn among those that are as good as the best; nullptr where nothing is alike.
const Impostor* smallest_turn(const std::vector<Impostor>& impostors, const Pattern& pattern) {
  const Impostor* smallest = nullptr;
  double best = 0.0;
  for (const Impostor& each : impostors) {
    if (is_turned(each, pattern)) best = std::max(best, each.score);
  }
  for (const Impostor& each : impostors) {
    if (!is_turned(each, pattern) || each.score < std::max(alike, best - as_good)) continue;
    if (smallest == nullptr || std::abs(each.turn_deg) < std::abs(smallest->turn_deg) - 0.5) smallest = &each;
  }
  return smallest;
}

/// The smallest shift that leaves the pattern alike, and the smallest one across it.
std::vector<Impostor> periods(const std::vector<Impostor>& impostors, const Pattern& pattern,
                              const Undetermined& known) {
  std::vector<Impostor> found;
  for (Impostor each : impostors) {
    if (each.score < alike || !is_period(each, pattern)) continue;
    if (known.directions == 1) {
      // Along that direction the pattern may lie anywhere; what counts is how far it has moved across.
      const double a = known.direction_deg / degrees;
      const Eigen::Vector2d along(std::cos(a), std::sin(a));
      each.shift -= along * along.dot(each.shift);
      constexpr double in_place = 0.05;  // of the pattern's size
      if (each.shift.norm() < in_place * std::min(pattern.width, pattern.height)) continue;
    }
    found.push_back(each);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Impostor& a, const Impostor& b) { return a.shift.norm() < b.shift.norm() - 0.5; });
  std::vector<Impostor> kept;
  for (const Impostor& each : found) {
    constexpr double across = 30.0;
    const bool parallel = std::any_of(kept.begin(), kept.end(), [&](const Impostor& other) {
      return std::abs(std::remainder(direction_of(each) - direction_of(other), 180.0)) < across;
    });
    if (!parallel && kept.size() < 2) kept.push_back(each);
  }
  return kept;
}

}  // namespace

std::vector<Impostor> find_impostors(TrainingScene& scene, const Pattern& pattern,
                                     const std::vector<OtherScene>& others) {
  std::vector<Impostor> found;
  Measuring measuring(scene, pattern);
  measuring.in_scene(scene.image(), scene.pyramid(), -1, found);
  measuring.shifted(found);
  measuring.turned(found);
  for (std::size_t i = 0; i < others.size(); ++i) {
    measuring.in_scene(others[i].image, *others[i].pyramid, static_cast<int>(i), found);
  }
  std::stable_sort(found.begin(), found.end(), [](const Impostor& a, const Impostor& b) { return a.score > b.score; });
  // Of those as good as the best, the nearest says most.
  const auto equal_end = std::find_if(found.begin(), found.end(), [&](const Impostor& each) {
    constexpr double equal = 0.005;
    return each.score < found.front().score - equal;
  });
  const auto nearest = std::min_element(found.begin(), equal_end, [](const Impostor& a, const Impostor& b) {
    return std::pair(a.scene, a.shift.norm()) < std::pair(b.scene, b.shift.norm());
  });
  if (nearest != equal_end) std::iter_swap(found.begin(), nearest);
  return found;
}

std::string describe(const Impostor& impostor, const Pattern& pattern) {
  if (is_turned(impostor, pattern)) return fmt::format("turned by {:.0f} degrees", std::abs(impostor.turn_deg));
  if (is_period(impostor, pattern)) {
    return fmt::format("shifted by {:.1f}, {:.1f} pixels", impostor.shift.x(), impostor.shift.y());
  }
  return place_text(impostor);
}

std::vector<std::string> warnings_of(const std::vector<Impostor>& impostors, const Pattern& pattern,
                                     const Undetermined& known) {
  std::vector<std::string> warnings;
  if (const Impostor* turned = known.angle ? nullptr : smallest_turn(impostors, pattern)) {
    warnings.push_back(
        fmt::format("the pattern looks the same turned by {:.0f} degrees ({:.2f}): its angle is told "
                    "only up to that",
                    std::abs(turned->turn_deg), turned->score));
  }
  const std::vector<Impostor> repeated = periods(impostors, pattern, known);
  for (const Impostor& period : repeated) {
    warnings.push_back(
        fmt::format("the pattern repeats every {:.1f} pixels along {} ({:.2f}): a neighbour may be "
                    "taken for it",
                    period.shift.norm(), direction_text(direction_of(period)), period.score));
  }
  for (const Impostor& each : impostors) {
    constexpr double worth_a_word = 0.7;
    if (each.score < worth_a_word || is_turned(each, pattern) || is_period(each, pattern)) continue;
    if (each.scene < 0) {
      // Said already: another one of the row, slid along itself, or turned about a middle that is not the ROI's.
      constexpr double straight = 2.0;
      if ((!repeated.empty() || known.directions > 0) && std::abs(each.turn_deg) < straight) continue;
      if (known.angle && each.shift.norm() < std::hypot(pattern.width, pattern.height) / 2.0) continue;
    }
    warnings.push_back(fmt::format("something {} looks like the pattern ({:.2f})", place_text(each), each.score));
    break;
  }
  return warnings;
}

}  // namespace vsfind
