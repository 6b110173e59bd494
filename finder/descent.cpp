#include "finder/descent.h"

#include <algorithm>
#include <cmath>

#include "finder/sampling.h"

namespace vsfind {

void Descent::climb(const PreparedPattern& prepared, const SearchScene& scene, Candidate& candidate) {
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

double Descent::likeness(const PointArrays& points, Polarity polarity) const {
  // Each edge may have become stronger or weaker: what agrees with one gain says less than how all of them correlate.
  double inside = 0.0;
  const double correlation = fit_.correlation_as_read(points, inside);
  return inside * oriented(correlation, polarity);
}

/// One level as candidates are fitted on it.
struct Descent::Stage {
  const PreparedPattern& prepared;
  const SearchScene& scene;
  int index;
  std::size_t wanted;
  const PointArrays& points;
  Projection projection;
  SmoothingReader reader;
  double pixel;  ///< of the level, plane units

  Stage(const PreparedPattern& pattern, const SearchScene& picture, int level, std::size_t matches)
      : prepared(pattern),
        scene(picture),
        index(level),
        wanted(matches),
        points(pattern.follow[static_cast<std::size_t>(level)]),
        projection{picture.mapping, &picture.pyramid->level(level), pattern.pattern->pitch},
        reader(picture.pyramid->level(level)),
        pixel(std::ldexp(pattern.pattern->pitch, level)) {}

  [[nodiscard]] bool top() const { return index == prepared.pattern->top_level; }
};

double Descent::follow(const Stage& stage, double best, Candidate& candidate) {
  const PreparedPattern& prepared = stage.prepared;
  const Pattern& p = *prepared.pattern;
  Pose before = candidate.pose;
  FitOptions fit;
  fit.freedom = prepared.freedom;
  fit.iterations = stage.top() ? 6 : 4;
  fit.step_tolerance = 0.03;
  fit.settle = false;
  fit.polarity = p.polarity;
  fit.start = candidate.line;
  double inside = 0.0;
  const auto explained = [&](const FitResult& result) {
    inside = result.inside;
    if (!result.ok || oriented(result.gain, p.polarity) <= 0.0) return 0.0;
    return p.edges ? std::max(result.explained, likeness(stage.points, p.polarity)) : result.explained;
  };
  constexpr double furthest = 4.0;  // level pixels: a fit that runs further has found something else
  // Of a candidate at `from`: its pose, score and line.
  const auto fitted = [&](const Pose& from) {
    Candidate at = candidate;
    at.pose = from;
    at.score = -1.0;
    at.line = {};
    const FitResult result = fit_.fit(stage.points, stage.projection, stage.reader, fit, at.pose);
    const double moved = std::hypot(at.pose.x - before.x, at.pose.y - before.y) / stage.pixel;
    if (!result.ok || moved > furthest || !prepared.in_range(at.pose)) return at;
    at.score = explained(result);
    if (at.score >= sure_part) at.line = {result.gain, result.offset};
    return at;
  };
  const auto take_better = [&](const Candidate& other) {
    if (other.score > candidate.score) candidate = other;
  };
  // Shading costs time: it is fitted where without it too little agrees.
  candidate = fitted(before);
  fit.freedom.shading = true;
  // Where one is wanted, what agrees by less than half as much as a clearly good one is not tried any further.
  const bool hopeless = stage.wanted == 1 && best >= sure_part && candidate.score < 0.5 * best;
  if (candidate.score < sure_part && !hopeless) take_better(fitted(before));
  if (candidate.score < sure_part && stage.top() && !hopeless) {
    // The least squares need to start on the right slope.
    Candidate climbed = candidate;
    climbed.pose = before;
    climb(prepared, stage.scene, climbed);
    before = climbed.pose;
    take_better(fitted(before));
  }
  constexpr double doubtful = 0.7;
  constexpr double nothing = 0.15;
  if (candidate.score > nothing && candidate.score < doubtful && stage.top() && best < sure_part) {
    // From further off all points together may find the slope that the agreeing ones do not see.
    Pose other = before;
    FitOptions all = fit;
    all.robust = false;
    all.iterations = 4;
    if (fit_.fit(stage.points, stage.projection, stage.reader, all, other).ok) take_better(fitted(other));
  }
  if (candidate.score < 0.0) {
    candidate.pose = before;
    FitOptions still = fit;
    still.iterations = 0;
    Pose same = before;
    candidate.score = explained(fit_.fit(stage.points, stage.projection, stage.reader, still, same));
  }
  return inside;
}

void Descent::thin_out(const Stage& stage, double min_score, double known, std::vector<Candidate>& candidates) {
  const Pattern& p = *stage.prepared.pattern;
  std::sort(kept_.begin(), kept_.end(), [](const Candidate& a, const Candidate& b) {
    return a.score != b.score ? a.score > b.score : precedes(a.pose, b.pose);
  });
  candidates.clear();
  // What cannot be told apart yet goes on: a hidden or blurred pattern explains little at one level, more at the next.
  constexpr double least_of_last = 0.22;
  const double least = std::max(0.25 * min_score, stage.index <= 1 ? std::min(least_of_last, 0.7 * min_score) : 0.0);
  const double best = std::max(known, kept_.empty() ? 0.0 : kept_.front().score);
  const std::size_t wanted = stage.wanted;
  const double window = wanted == 1 ? best * (best > sure_part ? 0.85 : 0.6) : 0.0;
  const std::size_t most = stage.top() ? 12 + 4 * wanted : stage.index > 1 ? 7 + 3 * wanted : 3 + 2 * wanted;
  for (const Candidate& candidate : kept_) {
    if (candidates.size() >= most || candidate.score < std::max(least, window)) break;
    const bool twice = std::any_of(candidates.begin(), candidates.end(), [&](const Candidate& other) {
      return std::hypot(other.pose.x - candidate.pose.x, other.pose.y - candidate.pose.y) < 1.5 * stage.pixel &&
             (!stage.prepared.freedom.angle ||
              angle_between(other.pose.angle_deg, candidate.pose.angle_deg) < p.angle_step_deg);
    });
    if (!twice) candidates.push_back(candidate);
  }
}

void Descent::run(const PreparedPattern& prepared, const SearchScene& scene, const SearchOptions& options, double known,
                  std::chrono::steady_clock::time_point deadline, std::vector<Candidate>& candidates, bool& timed_out) {
  const int top = prepared.pattern->top_level;
  for (int index = top; index >= std::min(top, 1); --index) {
    const Stage stage(prepared, scene, index, options.wanted());
    kept_.clear();
    double best = 0.0;
    for (Candidate candidate : candidates) {
      if (std::chrono::steady_clock::now() > deadline) {
        timed_out = true;
        break;
      }
      const double inside = follow(stage, best, candidate);
      best = std::max(best, candidate.score);
      if (inside >= 0.5) kept_.push_back(candidate);
    }
    thin_out(stage, options.min_score, known, candidates);
  }
}

}  // namespace vsfind
