#include "finder/pattern_search.h"

#include <algorithm>
#include <cmath>

namespace vsfind {

namespace {

/// Candidates that are followed at first.
constexpr std::size_t first_batch = 6;
/// Candidates that score less than this part of the best one wait until that has turned out to be nothing.
constexpr float clear_lead = 0.8F;
/// Score, and explained part, from which on a match leaves no doubt: what is nearly symmetric looks like itself, too.
constexpr double convincing_part = 0.9;
/// The same, from which on candidates that a match leads clearly are not looked at any more.
constexpr double likely_part = 0.55;

bool in_region(const SearchOptions& options, const Eigen::Vector2d& frame) {
  if (!options.region) return true;
  const Roi& r = *options.region;
  return frame.x() > r.x - 0.5 && frame.y() > r.y - 0.5 && frame.x() < r.x + r.width - 0.5 &&
         frame.y() < r.y + r.height - 0.5;
}

}  // namespace

void PatternSearch::run(const PreparedPattern& prepared, const SearchScene& scene, const SearchOptions& options,
                        ThreadPool& threads, std::chrono::steady_clock::time_point deadline, PatternMatches& out) {
  out.matches.clear();
  out.timed_out = false;
  const Pattern& p = *prepared.pattern;
  if (p.top_level >= scene.pyramid->levels()) return;
  const std::size_t wanted = options.wanted();
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
  task.deadline = deadline;
  if (!coarse_.run(task, threads, peaks_)) {
    out.timed_out = true;
    return;
  }

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
    double known = 0.0;
    for (const Found& each : found_) known = std::max(known, each.explained);
    descent_.run(prepared, scene, options, known, deadline, candidates_, out.timed_out);
    for (Candidate& candidate : candidates_) {
      if (std::chrono::steady_clock::now() > deadline) out.timed_out = true;
      if (out.timed_out && !found_.empty()) break;
      Match match;
      if (!final_fit_.run(prepared, scene, options.min_score, candidate, match) || match.score < options.min_score ||
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
