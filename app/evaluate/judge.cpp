#include "app/evaluate/judge.h"

#include <algorithm>
#include <cmath>

namespace vsfind {
namespace {

struct Pair {
  std::size_t truth;
  std::size_t match;
  double distance;
};

Eigen::Vector2d place_of(const Match& match, bool in_frame_pixels) {
  return in_frame_pixels ? match.frame_position : Eigen::Vector2d(match.pose.x, match.pose.y);
}

}  // namespace

std::vector<Judgement> judge_picture(const std::vector<Match>& matches, const std::vector<TruthRow>& truth,
                                     bool in_frame_pixels, const Tolerance& tolerance) {
  std::vector<Pair> pairs;
  for (std::size_t t = 0; t < truth.size(); ++t) {
    if (!truth[t].present) continue;
    for (std::size_t m = 0; m < matches.size(); ++m) {
      const double distance = (place_of(matches[m], in_frame_pixels) - Eigen::Vector2d(truth[t].x, truth[t].y)).norm();
      const double turn =
          truth[t].angle_deg ? std::remainder(matches[m].pose.angle_deg - *truth[t].angle_deg, 360.0) : 0.0;
      if (distance <= tolerance.position && std::abs(turn) <= tolerance.angle_deg) pairs.push_back({t, m, distance});
    }
  }
  std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.distance < b.distance; });
  std::vector<bool> answered(truth.size(), false);
  std::vector<bool> taken(matches.size(), false);
  std::vector<Judgement> judgements;
  for (const Pair& pair : pairs) {
    if (answered[pair.truth] || taken[pair.match]) continue;
    answered[pair.truth] = taken[pair.match] = true;
    Judgement& right = judgements.emplace_back();
    right.truth = truth[pair.truth];
    right.match = matches[pair.match];
    const Eigen::Vector2d error =
        place_of(*right.match, in_frame_pixels) - Eigen::Vector2d(right.truth->x, right.truth->y);
    right.error_x = error.x();
    right.error_y = error.y();
    const Pose& pose = right.match->pose;
    if (right.truth->angle_deg) right.error_angle_deg = std::remainder(pose.angle_deg - *right.truth->angle_deg, 360.0);
    if (right.truth->scale_x) right.error_scale_x = pose.scale_x - *right.truth->scale_x;
    if (right.truth->scale_y) right.error_scale_y = pose.scale_y - *right.truth->scale_y;
  }
  for (std::size_t t = 0; t < truth.size(); ++t) {
    if (!truth[t].present || answered[t]) continue;
    Judgement& missed = judgements.emplace_back();
    missed.verdict = Verdict::missed;
    missed.truth = truth[t];
  }
  for (std::size_t m = 0; m < matches.size(); ++m) {
    if (taken[m]) continue;
    Judgement& alarm = judgements.emplace_back();
    alarm.verdict = Verdict::false_alarm;
    alarm.match = matches[m];
  }
  return judgements;
}

}  // namespace vsfind
