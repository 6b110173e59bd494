#include "finder/pattern_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "finder/training_scene.h"

namespace vsfind {

namespace {

/// Candidates that are followed at first.
constexpr std::size_t first_batch = 6;
/// Candidates that score less than this part of the best one wait until that has turned out to be nothing.
constexpr float clear_lead = 0.8F;
/// Explained part of the pattern from which on a candidate is clearly better than a chance likeness.
constexpr double sure_part = 0.8;
/// Score, and explained part, from which on a match leaves no doubt: what is nearly symmetric looks like itself, too.
constexpr double convincing_part = 0.9;
/// The same, from which on candidates that a match leads clearly are not looked at any more.
constexpr double likely_part = 0.55;
/// Part of the least score that a candidate must reach before the last fit.
constexpr double near_enough = 0.7;

double oriented(double score, Polarity polarity) {
  return polarity == Polarity::same ? score : polarity == Polarity::reversed ? -score : std::abs(score);
}

/// The order of what is equally good.
bool precedes(const Pose& a, const Pose& b) {
  return a.y != b.y ? a.y < b.y : a.x != b.x ? a.x < b.x : a.angle_deg < b.angle_deg;
}

double angle_between(double a, double b) { return std::abs(std::remainder(a - b, 360.0)); }

/// A pose found may lie a little outside the range asked for: the last half step is refined like any other.
bool in_range(const PreparedPattern& prepared, const Pose& pose) {
  const Pattern& p = *prepared.pattern;
  if (prepared.freedom.angle && prepared.angle_deg.width() < 360.0) {
    const double slack = std::min(2.0, p.angle_step_deg / 2.0);
    const double middle = (prepared.angle_deg.min + prepared.angle_deg.max) / 2.0;
    if (angle_between(pose.angle_deg, middle) > prepared.angle_deg.width() / 2.0 + slack) return false;
  }
  const double slack = 1.0 + std::min(0.05, p.scale_step / 2.0);
  const auto within = [&](double scale, const Range& range) {
    return !range.searched() || (scale > range.min / slack && scale < range.max * slack);
  };
  return within(pose.scale_x, prepared.scale_x) && within(pose.scale_y, prepared.scale_y);
}

bool in_region(const SearchOptions& options, const Eigen::Vector2d& frame) {
  if (!options.region) return true;
  const Roi& r = *options.region;
  return frame.x() > r.x - 0.5 && frame.y() > r.y - 0.5 && frame.x() < r.x + r.width - 0.5 &&
         frame.y() < r.y + r.height - 0.5;
}

/// Whether optics that blur the picture evenly may blur the plane more in one direction than in another.
bool blurs_by_direction(const Mapping& mapping) {
  constexpr double square = 0.02;  // a difference that is lost in the noise
  return !mapping.affine() || std::abs(mapping.pixel_aspect() - 1.0) > square;
}

/// Whether two poses of one picture differ by no more than noise lets the first one be off: else one of them suffers
/// from something worse.
bool agree(const FitResult& fit, const PreparedPattern& prepared, const Pose& first, const Pose& second) {
  constexpr double sigmas = 4.0;
  const double angle = first.angle_deg * std::numbers::pi / 180.0;
  const double dx = (second.x - first.x) / prepared.pattern->pitch;
  const double dy = (second.y - first.y) / prepared.pattern->pitch;
  Eigen::Matrix<double, 5, 1> off;
  off << (std::cos(angle) * dx + std::sin(angle) * dy) / first.scale_x,
      (std::cos(angle) * dy - std::sin(angle) * dx) / first.scale_y,
      std::remainder(second.angle_deg - first.angle_deg, 360.0) * std::numbers::pi / 180.0,
      second.scale_x - first.scale_x, second.scale_y - first.scale_y;
  const Eigen::Matrix<double, 5, 1> sigma =
      fit.covariance.diagonal().cwiseProduct(prepared.inflation).cwiseMax(0.0).cwiseSqrt() * fit.residual;
  return (off.cwiseAbs().array() <= sigmas * sigma.array() + 1e-9).all();
}

}  // namespace

void PatternSearch::climb(const PreparedPattern& prepared, const SearchScene& scene, Candidate& candidate) {
  // Uphill with the tolerant points of the exhaustive search, from its grid to a quarter of its steps: the least
  // squares that follow need to start on the right slope.
  const Pattern& p = *prepared.pattern;
  const Level& level = scene.pyramid->smoothed(p.top_level);
  const Projection projection{scene.mapping, &level, p.pitch};
  const BilinearReader reader(level);
  double inside = 0.0;
  double best = oriented(fit_.correlation(prepared.climb, projection, reader, candidate.pose, inside), p.polarity);
  const double pixel = std::ldexp(p.pitch, p.top_level);
  for (const double part : {0.5, 0.25}) {
    const double shift = 2.0 * part * pixel;
    const double turn = prepared.freedom.angle ? part * p.angle_step_deg : 0.0;
    const double grow_x = prepared.freedom.scale_x ? part * p.scale_step : 0.0;
    const double grow_y = prepared.freedom.scale_y ? part * p.scale_step : 0.0;
    constexpr int rounds = 3;
    for (int round = 0; round < rounds; ++round) {
      bool better = false;
      const auto attempt = [&](const Pose& pose) {
        const double score = oriented(fit_.correlation(prepared.climb, projection, reader, pose, inside), p.polarity);
        if (score <= best || inside < 0.5) return false;
        best = score;
        candidate.pose = pose;
        better = true;
        return true;
      };
      const auto both_ways = [&](auto change) {
        Pose pose = candidate.pose;
        change(pose, 1.0);
        if (attempt(pose)) return;
        pose = candidate.pose;
        change(pose, -1.0);
        attempt(pose);
      };
      both_ways([&](Pose& pose, double way) { pose.x += way * shift; });
      both_ways([&](Pose& pose, double way) { pose.y += way * shift; });
      if (turn > 0.0) both_ways([&](Pose& pose, double way) { pose.angle_deg += way * turn; });
      if (prepared.freedom.common_scale) {
        both_ways([&](Pose& pose, double way) {
          pose.scale_x *= 1.0 + way * grow_x;
          pose.scale_y = pose.scale_x;
        });
      } else {
        if (grow_x > 0.0) both_ways([&](Pose& pose, double way) { pose.scale_x *= 1.0 + way * grow_x; });
        if (grow_y > 0.0) both_ways([&](Pose& pose, double way) { pose.scale_y *= 1.0 + way * grow_y; });
      }
      if (!better) break;
    }
  }
  candidate.score = best;
}

double PatternSearch::likeness(const PointArrays& points, Polarity polarity) const {
  // Each edge may have become stronger or weaker: what agrees with one gain says less than how all of them correlate.
  double inside = 0.0;
  const double correlation = fit_.correlation_as_read(points, inside);
  return inside * oriented(correlation, polarity);
}

void PatternSearch::follow_down(const PreparedPattern& prepared, const SearchScene& scene, const SearchOptions& options,
                                std::chrono::steady_clock::time_point deadline, bool& timed_out) {
  const Pattern& p = *prepared.pattern;
  const std::size_t wanted = options.max_instances == 0 ? 200 : static_cast<std::size_t>(options.max_instances);
  for (int index = p.top_level; index >= (p.top_level == 0 ? 0 : 1); --index) {
    const PointArrays& points = prepared.follow[static_cast<std::size_t>(index)];
    const Level& level = scene.pyramid->level(index);
    const Projection projection{scene.mapping, &level, p.pitch};
    const SmoothingReader reader(level);
    FitOptions fit;
    fit.freedom = prepared.freedom;
    fit.freedom.shading = true;
    fit.iterations = index == p.top_level ? 6 : 4;
    fit.step_tolerance = 0.03;
    fit.settle = false;
    fit.polarity = p.polarity;
    const double pixel = std::ldexp(p.pitch, index);
    kept_.clear();
    double best_score = 0.0;
    for (Candidate candidate : candidates_) {
      if (std::chrono::steady_clock::now() > deadline) {
        timed_out = true;
        break;
      }
      Pose before = candidate.pose;
      fit.start = candidate.line;
      double inside = 0.0;
      const auto explained = [&](const FitResult& result) {
        inside = result.inside;
        if (!result.ok || oriented(result.gain, p.polarity) <= 0.0) return 0.0;
        return p.edges ? std::max(result.explained, likeness(points, p.polarity)) : result.explained;
      };
      constexpr double furthest = 4.0;  // level pixels: a fit that runs further has found something else
      // Of a candidate at `from`: its pose, score and line.
      const auto fitted = [&](const Pose& from) {
        Candidate at = candidate;
        at.pose = from;
        at.score = -1.0;
        at.line = {};
        const FitResult result = fit_.fit(points, projection, reader, fit, at.pose);
        const double moved = std::hypot(at.pose.x - before.x, at.pose.y - before.y) / pixel;
        if (!result.ok || moved > furthest || !in_range(prepared, at.pose)) return at;
        at.score = explained(result);
        if (at.score >= sure_part) at.line = {result.gain, result.offset};
        return at;
      };
      const auto take_better = [&](const Candidate& other) {
        if (other.score > candidate.score) candidate = other;
      };
      // Shading costs time: it is fitted where without it too little agrees.
      fit.freedom.shading = false;
      candidate = fitted(before);
      fit.freedom.shading = true;
      // Where one is wanted, what agrees by less than half as much as a clearly good one is not tried any further.
      const bool hopeless = wanted == 1 && best_score >= sure_part && candidate.score < 0.5 * best_score;
      if (candidate.score < sure_part && !hopeless) take_better(fitted(before));
      if (candidate.score < sure_part && index == p.top_level && !hopeless) {
        // The least squares need to start on the right slope.
        Candidate climbed = candidate;
        climbed.pose = before;
        climb(prepared, scene, climbed);
        before = climbed.pose;
        take_better(fitted(before));
      }
      constexpr double doubtful = 0.7;
      constexpr double nothing = 0.15;
      if (candidate.score > nothing && candidate.score < doubtful && index == p.top_level && best_score < sure_part) {
        // From further off all points together may find the slope that the agreeing ones do not see.
        Pose other = before;
        FitOptions all = fit;
        all.robust = false;
        all.iterations = 4;
        if (fit_.fit(points, projection, reader, all, other).ok) take_better(fitted(other));
      }
      best_score = std::max(best_score, candidate.score);
      if (candidate.score < 0.0) {
        candidate.pose = before;
        FitOptions still = fit;
        still.iterations = 0;
        Pose same = before;
        candidate.score = explained(fit_.fit(points, projection, reader, still, same));
      }
      if (inside >= 0.5) kept_.push_back(candidate);
    }
    std::sort(kept_.begin(), kept_.end(), [](const Candidate& a, const Candidate& b) {
      return a.score != b.score ? a.score > b.score : precedes(a.pose, b.pose);
    });
    candidates_.clear();
    // What cannot be told apart yet goes on: a hidden or blurred pattern explains little at one level, more at the
    // next.
    constexpr double least_of_last = 0.22;
    const double least =
        std::max(0.25 * options.min_score, index <= 1 ? std::min(least_of_last, 0.7 * options.min_score) : 0.0);
    double best = kept_.empty() ? 0.0 : kept_.front().score;
    for (const Found& each : found_) best = std::max(best, each.explained);
    const double window = wanted == 1 ? best * (best > sure_part ? 0.85 : 0.6) : 0.0;
    const std::size_t most = index == p.top_level ? 12 + 4 * wanted : index > 1 ? 7 + 3 * wanted : 3 + 2 * wanted;
    for (const Candidate& candidate : kept_) {
      if (candidates_.size() >= most || candidate.score < std::max(least, window)) break;
      const bool known = std::any_of(candidates_.begin(), candidates_.end(), [&](const Candidate& other) {
        return std::hypot(other.pose.x - candidate.pose.x, other.pose.y - candidate.pose.y) < 1.5 * pixel &&
               (!prepared.freedom.angle ||
                angle_between(other.pose.angle_deg, candidate.pose.angle_deg) < p.angle_step_deg);
      });
      if (!known) candidates_.push_back(candidate);
    }
  }
}

FitResult PatternSearch::look(const PreparedPattern& prepared, const Projection& projection, const Reader& reader,
                              Match& match) {
  FitOptions seen;
  seen.freedom.shading = true;
  seen.freedom.blur = true;
  seen.iterations = 0;
  seen.polarity = prepared.pattern->polarity;
  Pose same = match.pose;
  FitResult view = fit_.fit(prepared.verify, projection, reader, seen, same);
  double inside = 0.0;
  const double signed_score = fit_.correlation_as_read(prepared.verify, inside);
  match.score = std::clamp(oriented(signed_score, prepared.pattern->polarity), 0.0, 1.0);
  match.polarity = signed_score < 0.0 ? Polarity::reversed : Polarity::same;
  return view;
}

bool PatternSearch::finish(const PreparedPattern& prepared, const SearchScene& scene, double min_score,
                           Candidate& candidate, Match& match) {
  const Pattern& p = *prepared.pattern;
  const Level& level = scene.pyramid->level(0);
  const Projection projection{scene.mapping, &level, p.pitch};
  const Eigen::Vector2d image = scene.mapping->image_from_plane({candidate.pose.x, candidate.pose.y});
  if (!image.allFinite()) return false;
  const double scale = std::sqrt(candidate.pose.scale_x * candidate.pose.scale_y);
  const GaussianReader reader = gaussian_reader(scene.image, *scene.mapping, image, p.pitch, scale);
  // Where the levels above left it, what is right correlates nearly as it will in the end: no fit makes up for more.
  double inside = 0.0;
  const double here = oriented(fit_.correlation(prepared.verify, projection, reader, candidate.pose, inside), p.polarity);
  if (here < near_enough * min_score) return false;
  FitOptions options;
  options.freedom = prepared.fine_freedom();
  options.freedom.shading = false;
  options.freedom.directional_blur = blurs_by_direction(*scene.mapping);
  options.trusted = prepared.trusted;
  options.polarity = p.polarity;
  options.iterations = 8;
  options.step_tolerance = 1e-3;
  options.covariance = true;
  options.try_shading = true;
  options.start = candidate.line;
  match.pose = candidate.pose;
  FitResult fit = fit_.fit(prepared.refine, projection, reader, options, match.pose);
  // Where there is no shading, columns for it only cost accuracy: they are used where they leave clearly less.
  constexpr double clearly_less = 1.0 / 1.15;
  constexpr double as_visible = 0.03;
  if (!fit.ok || fit.shaded_residual < clearly_less * fit.residual || fit.visible < 1.0 - as_visible) {
    FitOptions shaded = options;
    shaded.freedom.shading = true;
    shaded.try_shading = false;
    Pose pose = candidate.pose;
    const FitResult with = fit_.fit(prepared.refine, projection, reader, shaded, pose);
    if (with.ok &&
        (!fit.ok || with.residual < clearly_less * fit.residual || with.visible > fit.visible + as_visible)) {
      fit = with;
      match.pose = pose;
    }
  }
  // Where much is hidden the level above may have left it further off than the slopes reach, on which the best points
  // lie: points all over the pattern lead back.
  constexpr double well_seen = 0.85;
  if (!fit.ok || fit.visible < well_seen) {
    FitOptions wide = options;
    wide.try_shading = false;
    wide.covariance = false;
    wide.trusted = 0;
    Pose pose = candidate.pose;
    if (fit_.fit(prepared.verify, projection, reader, wide, pose).ok) {
      const FitResult again = fit_.fit(prepared.refine, projection, reader, options, pose);
      if (again.ok && (!fit.ok || again.visible > fit.visible + as_visible)) {
        fit = again;
        match.pose = pose;
      }
    }
  }
  bool independent = false;
  // With scales to be found as well the few best points leave too much to the noise, and so they do where pixels are
  // not square, which the pattern's are: all pixels beside them are used.
  const bool scaled = prepared.freedom.scale_x || prepared.freedom.scale_y;
  const bool oblong = scene.mapping->affine() && blurs_by_direction(*scene.mapping);
  const bool between_lines =
      scene.mapping->field() != Field::frame && !p.from_field && FieldFit::pays(projection, match.pose);
  if (fit.ok && !p.edges && (between_lines || scaled || oblong)) {
    FitOptions on_lines = options;
    on_lines.try_shading = false;
    on_lines.start = {fit.gain, fit.offset};
    on_lines.first_iteration = 2;
    Pose pose = match.pose;
    const FitResult polished =
        field_fit_.fit(prepared.spline, prepared.refine, scene.image, projection, on_lines, fit_, pose);
    if (polished.ok && (between_lines || agree(fit, prepared, match.pose, pose))) {
      fit = polished;
      independent = true;
      match.pose = pose;
    }
  }
  if (!fit.ok || !in_range(prepared, match.pose)) return false;
  constexpr double furthest = 8.0;  // full-resolution pixels from where the level above left it
  if (std::hypot(match.pose.x - candidate.pose.x, match.pose.y - candidate.pose.y) > furthest * p.pitch) return false;

  FitResult view = look(prepared, projection, reader, match);
  // The few best points fix a true copy of the pattern best, whatever hides some of it. Where instead the pattern
  // itself is another piece of its kind, so that much disagrees a little, all of it together has the say: that is the
  // pose of the highest correlation.
  constexpr double alike = 0.95;
  constexpr double agreeing = 0.9;
  constexpr double far_off = 0.1;
  const bool another = (match.score >= alike && fit.visible < agreeing * view.visible) ||
                       (!p.edges && fit.residual > far_off * std::abs(fit.gain) * prepared.refine.contrast);
  if (another) {
    FitOptions all = options;
    all.robust = false;
    all.trusted = 0;
    all.try_shading = false;
    Match whole = match;
    const FitResult dense = fit_.fit(prepared.verify, projection, reader, all, whole.pose);
    if (dense.ok && in_range(prepared, whole.pose)) {
      fit = dense;
      independent = false;
      match = whole;
      view = look(prepared, projection, reader, match);
    }
  }
  match.visible = view.visible;
  candidate.score = p.edges ? std::max(view.explained, match.score * view.visible) : view.explained;
  // The less of a pattern is seen, the easier something else looks like it: what is inside the picture must agree
  // better, and what resembles it only as a whole, a dark patch for a dark part, must be seen to a good part.
  constexpr double least_inside = 0.9;
  constexpr double least_seen = 0.65;
  if (match.score * view.inside < least_inside * min_score) return false;
  if (match.score * view.visible < least_seen * min_score) return false;
  match.frame_position = scene.mapping->frame_from_image(scene.mapping->image_from_plane({match.pose.x, match.pose.y}));

  const Eigen::Matrix<double, 5, 1> sigma =
      fit.covariance.diagonal()
          .cwiseProduct(independent ? Eigen::Matrix<double, 5, 1>::Ones() : prepared.inflation)
          .cwiseMax(0.0)
          .cwiseSqrt() *
      fit.residual;
  const double angle = match.pose.angle_deg * std::numbers::pi / 180.0;
  const double along = sigma(0) * match.pose.scale_x * p.pitch;
  const double across = sigma(1) * match.pose.scale_y * p.pitch;
  match.sigma_x = std::hypot(std::cos(angle) * along, std::sin(angle) * across);
  match.sigma_y = std::hypot(std::sin(angle) * along, std::cos(angle) * across);
  match.sigma_angle_deg = prepared.freedom.angle ? sigma(2) * 180.0 / std::numbers::pi : 0.0;
  return true;
}

void PatternSearch::run(const PreparedPattern& prepared, const SearchScene& scene, const SearchOptions& options,
                        ThreadPool& threads, std::chrono::steady_clock::time_point deadline, PatternMatches& out) {
  out.matches.clear();
  out.timed_out = false;
  const Pattern& p = *prepared.pattern;
  if (p.top_level >= scene.pyramid->levels()) return;
  const std::size_t wanted = options.max_instances == 0 ? 200 : static_cast<std::size_t>(options.max_instances);
  CoarseTask task;
  task.points = &prepared.search;
  task.hypotheses = &prepared.hypotheses;
  const Level& top = scene.pyramid->smoothed(p.top_level);
  task.projection = {scene.mapping, &top, p.pitch};
  task.polarity = p.polarity;
  task.threshold = static_cast<float>(options.coarse_score.value_or(0.5 * options.min_score));
  task.most = 48 + 12 * std::min<std::size_t>(wanted, 30);
  task.places = wanted;
  std::optional<Roi> region = options.region;
  if (rectified_.update(top, *scene.mapping, 0.5 * std::hypot(p.width, p.height) * p.pitch)) {
    task.projection = {&rectified_.mapping(), &rectified_.level(), p.pitch};
    task.shown = &rectified_.shown();
    if (region) region = rectified_.region(*region);
  }
  task.region = region ? &*region : nullptr;
  coarse_.run(task, threads, peaks_);

  // The best candidates first; the others only where these do not settle the matter.
  found_.clear();
  std::size_t settled = 0;
  std::size_t next = 0;
  std::size_t batch = std::max<std::size_t>(first_batch, wanted + wanted / 4);
  while (next < peaks_.size() && settled < wanted && !out.timed_out) {
    candidates_.clear();
    for (; next < peaks_.size() && candidates_.size() < batch; ++next) {
      const CoarseCandidate& peak = peaks_[next];
      if (wanted == 1 && led_clearly(peak)) break;
      // Clear leaders go alone.
      if (found_.empty() && candidates_.size() >= wanted && peak.score < clear_lead * candidates_[wanted - 1].coarse)
        break;
      if (near_settled(prepared, peak.pose)) continue;
      candidates_.push_back({peak.pose, 0.0, peak.score, {}});
    }
    if (candidates_.empty()) break;
    follow_down(prepared, scene, options, deadline, out.timed_out);
    for (Candidate& candidate : candidates_) {
      if (std::chrono::steady_clock::now() > deadline) out.timed_out = true;
      if (out.timed_out && !found_.empty()) break;
      Match match;
      if (!finish(prepared, scene, options.min_score, candidate, match) || match.score < options.min_score ||
          !in_region(options, match.frame_position)) {
        continue;
      }
      // Less will do where nothing that is left comes near.
      const bool alone =
          next == peaks_.size() || std::abs(peaks_[next].score) < clear_lead * std::abs(candidate.coarse);
      const double enough = alone ? sure_part : convincing_part;
      const bool convincing = candidate.score >= enough && match.score >= enough;
      if (convincing && !near_settled(prepared, match.pose)) ++settled;
      found_.push_back({candidate.score, match, candidate.coarse, convincing});
      // The others explained less before their last fit, and would after it.
      if (settled >= wanted) break;
    }
    batch *= 3;
  }
  choose_matches(prepared, options, wanted, out);
}

bool PatternSearch::led_clearly(const CoarseCandidate& peak) const {
  return std::any_of(found_.begin(), found_.end(), [&](const Found& each) {
    return std::min(each.explained, each.match.score) >= likely_part &&
           std::abs(peak.score) < clear_lead * std::abs(each.coarse);
  });
}

bool PatternSearch::near_settled(const PreparedPattern& prepared, const Pose& pose) const {
  const Pattern& p = *prepared.pattern;
  constexpr double near = 0.3;  // of the pattern's size: such a neighbour shares more than half of its area
  const double reach = near * std::min(p.width, p.height) * p.pitch * std::min(pose.scale_x, pose.scale_y);
  // What is nearly symmetric looks much like itself when turned: only the better way leaves no doubt.
  constexpr double beyond_doubt = 0.95;
  constexpr double other_way = 20.0;  // degrees
  return std::any_of(found_.begin(), found_.end(), [&](const Found& each) {
    return each.convincing &&
           (each.match.score >= beyond_doubt || angle_between(each.match.pose.angle_deg, pose.angle_deg) < other_way) &&
           std::hypot(each.match.pose.x - pose.x, each.match.pose.y - pose.y) < reach;
  });
}

void PatternSearch::choose_matches(const PreparedPattern& prepared, const SearchOptions& options, std::size_t wanted,
                                   PatternMatches& out) {
  const Pattern& p = *prepared.pattern;
  // Ranked by how much of the pattern they explain; the score that is reported stays the plain correlation.
  std::sort(found_.begin(), found_.end(), [](const Found& a, const Found& b) {
    return a.explained != b.explained ? a.explained > b.explained : precedes(a.match.pose, b.match.pose);
  });
  for (const Found& each : found_) {
    const Match& match = each.match;
    if (out.matches.size() >= wanted) break;
    const Polygon outline = prepared.outline(match.pose);
    const bool covered = std::any_of(out.matches.begin(), out.matches.end(), [&](const Match& other) {
      const Polygon its = prepared.outline(other.pose);
      const double near = 0.05 * std::min(p.width, p.height) * p.pitch;
      const bool same_place = std::hypot(other.pose.x - match.pose.x, other.pose.y - match.pose.y) < near;
      return same_place || shared_area(outline, its) > options.max_overlap * std::min(area(outline), area(its));
    });
    if (!covered) out.matches.push_back(match);
  }
}

}  // namespace vsfind
