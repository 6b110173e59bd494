#include "finder/final_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "finder/sampling.h"
#include "finder/training_scene.h"

namespace vsfind {

namespace {

/// Part of the least score that a candidate must reach before the last fit.
constexpr double near_enough = 0.7;

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

/// The standard deviations to be expected of the match's pose. `independent`: whether no two points read the same
/// pixels.
void predict(const PreparedPattern& prepared, const FitResult& fit, bool independent, Match& match) {
  const Pattern& p = *prepared.pattern;
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
}

}  // namespace

FitResult FinalFit::look(const PreparedPattern& prepared, const Projection& projection, const Reader& reader,
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

FitResult FinalFit::fit_best_points(const PreparedPattern& prepared, const Projection& projection, const Reader& reader,
                                    const FitOptions& options, Pose& pose) {
  const Pose start = pose;
  FitResult fit = fit_.fit(prepared.refine, projection, reader, options, pose);
  // Where there is no shading, columns for it only cost accuracy: they are used where they leave clearly less.
  constexpr double clearly_less = 1.0 / 1.15;
  constexpr double as_visible = 0.03;
  if (!fit.ok || fit.shaded_residual < clearly_less * fit.residual || fit.visible < 1.0 - as_visible) {
    FitOptions shaded = options;
    shaded.freedom.shading = true;
    shaded.try_shading = false;
    Pose other = start;
    const FitResult with = fit_.fit(prepared.refine, projection, reader, shaded, other);
    if (with.ok &&
        (!fit.ok || with.residual < clearly_less * fit.residual || with.visible > fit.visible + as_visible)) {
      fit = with;
      pose = other;
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
    Pose other = start;
    if (fit_.fit(prepared.verify, projection, reader, wide, other).ok) {
      const FitResult again = fit_.fit(prepared.refine, projection, reader, options, other);
      if (again.ok && (!fit.ok || again.visible > fit.visible + as_visible)) {
        fit = again;
        pose = other;
      }
    }
  }
  return fit;
}

bool FinalFit::run(const PreparedPattern& prepared, const SearchScene& scene, double min_score, Candidate& candidate,
                   Match& match) {
  const Pattern& p = *prepared.pattern;
  const Level& level = scene.pyramid->level(0);
  const Projection projection{scene.mapping, &level, p.pitch};
  const Eigen::Vector2d image = scene.mapping->image_from_plane({candidate.pose.x, candidate.pose.y});
  if (!image.allFinite()) return false;
  const double scale = std::sqrt(candidate.pose.scale_x * candidate.pose.scale_y);
  const GaussianReader reader = gaussian_reader(scene.image, *scene.mapping, image, p.pitch, scale);
  if (candidate.score < sure_part) {
    // Where the levels above left it, what is right correlates nearly as it will in the end: no fit makes up for more.
    double inside = 0.0;
    const double here = fit_.correlation(prepared.verify, projection, reader, candidate.pose, inside);
    if (oriented(here, p.polarity) < near_enough * min_score) return false;
  }
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
  FitResult fit = fit_best_points(prepared, projection, reader, options, match.pose);
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
  if (!fit.ok || !prepared.in_range(match.pose)) return false;
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
    if (dense.ok && prepared.in_range(whole.pose)) {
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
  predict(prepared, fit, independent, match);
  return true;
}

}  // namespace vsfind
