#include "app/qualify/stage_analysis.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "acquisition/errors.h"

namespace vsfind {
namespace {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
constexpr double degrees = 180.0 / std::numbers::pi;

Deviations deviations(std::vector<double> values) {
  Deviations result{std::move(values), {}};
  result.spread = spread_of(result.values);
  return result;
}

/// From the least-squares line over the steps.
Deviations from_equal_steps(const std::vector<double>& values, const std::vector<double>& steps) {
  double n = 0.0, sum_i = 0.0, sum_v = 0.0, sum_ii = 0.0, sum_iv = 0.0;
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (!std::isfinite(values[k])) continue;
    const double i = steps[k];
    n += 1.0;
    sum_i += i;
    sum_v += values[k];
    sum_ii += i * i;
    sum_iv += i * values[k];
  }
  const double d = n * sum_ii - sum_i * sum_i;
  std::vector<double> left(values.size(), nothing);
  if (d <= 0.0) return deviations(std::move(left));
  const double slope = (n * sum_iv - sum_i * sum_v) / d;
  const double start = (sum_v - slope * sum_i) / n;
  for (std::size_t k = 0; k < values.size(); ++k) left[k] = values[k] - start - slope * steps[k];
  return deviations(std::move(left));
}

using Points = std::vector<std::optional<Eigen::Vector2d>>;

/// Distances from the straight line fitted to the points, and their places along it.
struct Straight {
  std::vector<double> across;
  std::vector<double> along;
  Eigen::Vector2d direction{0.0, 0.0};
};

Straight fit_straight(const Points& points) {
  Straight line;
  Eigen::Vector2d mean(0.0, 0.0);
  double n = 0.0;
  const Eigen::Vector2d* first = nullptr;
  const Eigen::Vector2d* last = nullptr;
  for (const auto& p : points) {
    if (!p) continue;
    mean += *p;
    n += 1.0;
    if (first == nullptr) first = &*p;
    last = &*p;
  }
  line.across.assign(points.size(), nothing);
  line.along.assign(points.size(), nothing);
  if (n < 2.0) return line;
  mean /= n;
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const auto& p : points) {
    if (p) scatter += (*p - mean) * (*p - mean).transpose();
  }
  line.direction = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(scatter).eigenvectors().col(1);
  if (line.direction.dot(*last - *first) < 0.0) line.direction = -line.direction;
  const Eigen::Vector2d normal(-line.direction.y(), line.direction.x());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i]) continue;
    line.across[i] = normal.dot(*points[i] - mean);
    line.along[i] = line.direction.dot(*points[i] - mean);
  }
  return line;
}

/// Angles without jumps of a full turn.
std::vector<double> unwrapped(std::vector<double> angles) {
  double last = nothing;
  for (double& a : angles) {
    if (!std::isfinite(a)) continue;
    if (std::isfinite(last)) a = last + std::remainder(a - last, 360.0);
    last = a;
  }
  return angles;
}

/// How far the values go from the first to the last that is known, and in how many steps.
void set_travel(StageAnalysis& result, const std::vector<double>& values, const std::vector<double>& steps) {
  const auto known = [](double v) { return std::isfinite(v); };
  const auto first = std::find_if(values.begin(), values.end(), known);
  if (first == values.end()) return;
  const auto last = std::find_if(values.rbegin(), values.rend(), known);
  result.travel = *last - *first;
  result.steps = steps[static_cast<std::size_t>(values.rend() - last) - 1] -
                 steps[static_cast<std::size_t>(first - values.begin())];
}

Deviations about_mean(std::vector<double> values) {
  const double mean = spread_of(values).mean;
  for (double& v : values) v -= mean;
  return deviations(std::move(values));
}

Eigen::Vector2d turned(const Eigen::Vector2d& p, double angle_deg) {
  const double c = std::cos(angle_deg / degrees);
  const double s = std::sin(angle_deg / degrees);
  return {c * p.x() - s * p.y(), s * p.x() + c * p.y()};
}

void compare_with_fiducials(const StageRun& run, StageAnalysis& result) {
  const std::size_t n = run.frames.size();
  std::vector<double> x(n, nothing), y(n, nothing), angle(n, nothing);
  for (std::size_t i = 0; i < n; ++i) {
    const StageFrame& frame = run.frames[i];
    if (!frame.match || !frame.fiducials) continue;
    ++result.with_fiducials;
    // A linear stage does not turn: there the fiducials' own angle would only add its noise.
    const double turn = result.kind == StageKind::rotary ? frame.fiducials->angle_deg : 0.0;
    const Eigen::Vector2d offset =
        turned(Eigen::Vector2d(frame.match->pose.x, frame.match->pose.y) - frame.fiducials->centre, -turn);
    x[i] = offset.x();
    y[i] = offset.y();
    angle[i] = frame.match->pose.angle_deg - frame.fiducials->angle_deg;
    result.fiducial_sigma += frame.fiducials->sigma;
    result.fiducial_sigma_angle_deg += frame.fiducials->sigma_angle_deg;
  }
  if (result.with_fiducials == 0) return;
  result.fiducial_sigma /= static_cast<double>(result.with_fiducials);
  result.fiducial_sigma_angle_deg /= static_cast<double>(result.with_fiducials);
  result.relative_x = about_mean(std::move(x));
  result.relative_y = about_mean(std::move(y));
  result.relative_angle = about_mean(unwrapped(std::move(angle)));
  for (std::size_t i = 0; i < n; ++i) {
    const double distance = std::hypot(result.relative_x.values[i], result.relative_y.values[i]);
    if (std::isfinite(distance)) result.relative_max = std::max(result.relative_max, distance);
  }
}

void compare_with_truth(const StageRun& run, StageAnalysis& result) {
  const std::size_t n = run.frames.size();
  std::vector<double> x(n, nothing), y(n, nothing), angle(n, nothing);
  for (std::size_t i = 0; i < n; ++i) {
    const StageFrame& frame = run.frames[i];
    if (!frame.match || !frame.truth) continue;
    x[i] = frame.match->pose.x - frame.truth->x;
    y[i] = frame.match->pose.y - frame.truth->y;
    angle[i] = std::remainder(frame.match->pose.angle_deg - frame.truth->angle_deg, 360.0);
  }
  result.truth_x = deviations(std::move(x));
  result.truth_y = deviations(std::move(y));
  result.truth_angle = deviations(std::move(angle));
}

void analyse_travel(const StageRun& run, StageAnalysis& result) {
  Points pattern, fiducials;
  std::vector<double> pattern_angle, fiducial_angle, steps;
  for (const StageFrame& frame : run.frames) {
    steps.push_back(frame.step);
    pattern.emplace_back();
    if (frame.match) pattern.back() = Eigen::Vector2d(frame.match->pose.x, frame.match->pose.y);
    pattern_angle.push_back(frame.match ? frame.match->pose.angle_deg : nothing);
    fiducials.emplace_back();
    if (frame.fiducials) fiducials.back() = frame.fiducials->centre;
    fiducial_angle.push_back(frame.fiducials ? frame.fiducials->angle_deg : nothing);
  }
  if (result.kind == StageKind::rotary) {
    const auto angles = unwrapped(std::move(pattern_angle));
    set_travel(result, angles, steps);
    result.pattern_turn = from_equal_steps(angles, steps);
    result.fiducials_turn = from_equal_steps(unwrapped(std::move(fiducial_angle)), steps);
    return;
  }
  Straight line = fit_straight(pattern);
  set_travel(result, line.along, steps);
  result.direction_deg = std::atan2(line.direction.y(), line.direction.x()) * degrees;
  result.pattern_across = deviations(std::move(line.across));
  result.pattern_along = from_equal_steps(line.along, steps);
  Straight other = fit_straight(fiducials);
  result.fiducials_across = deviations(std::move(other.across));
  result.fiducials_along = from_equal_steps(other.along, steps);
}

}  // namespace

double per_axis(const Deviations& x, const Deviations& y) {
  return std::sqrt((x.spread.sd * x.spread.sd + y.spread.sd * y.spread.sd) / 2.0);
}

StageAnalysis analyse_stage(const StageRun& run, StageKind kind) {
  StageAnalysis result;
  result.kind = kind;
  result.frames = run.frames.size();
  std::vector<double> ms;
  for (const StageFrame& frame : run.frames) {
    ms.push_back(frame.search_ms);
    if (!frame.match) continue;
    ++result.found;
    result.predicted_x += frame.match->sigma_x;
    result.predicted_y += frame.match->sigma_y;
    result.predicted_angle_deg += frame.match->sigma_angle_deg;
  }
  if (result.found < 3) {
    throw UsageError(
        fmt::format("{}: the pattern '{}' was found in {} of {} good frames (allowed: at least 3; a lower "
                    "--min-score, or a model trained on this target)",
                    run.source, run.pattern->name, result.found, result.frames));
  }
  const auto found = static_cast<double>(result.found);
  result.predicted_x /= found;
  result.predicted_y /= found;
  result.predicted_angle_deg /= found;
  result.median_ms = quantile_of(ms, 0.5);
  result.max_ms = quantile_of(ms, 1.0);
  analyse_travel(run, result);
  compare_with_fiducials(run, result);
  compare_with_truth(run, result);
  return result;
}

}  // namespace vsfind
