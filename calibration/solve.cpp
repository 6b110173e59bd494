#include "calibration/solve.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "acquisition/errors.h"
#include "calibration/disc_shift.h"
#include "calibration/lens_solve.h"
#include "calibration/plane_fit.h"

namespace vsfind {
namespace {

constexpr double degrees = 180.0 / std::numbers::pi;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The mappings of all views from one lens and their poses, or from homographies.
struct Fit {
  std::vector<Mapping> mappings;
  std::vector<std::optional<PlanePose>> poses;
  std::optional<Lens> lens;
  std::optional<LensUncertainty> uncertainty;
  std::optional<Eigen::Matrix3d> homography;  // of the plane's view
};

Fit fit_once(const std::vector<BoardView>& views, const SolveOptions& options) {
  Fit fit;
  if (options.lens) {
    fit.lens = options.lens;
    for (const BoardView& view : views) fit.poses.emplace_back(fit_plane_pose(*options.lens, view.board, view.frame));
  } else if (options.solve_lens && views.size() > 1) {
    SolvedLens solved = solve_lens(views, options);
    fit.lens = solved.lens;
    fit.uncertainty = solved.uncertainty;
    fit.poses.assign(solved.poses.begin(), solved.poses.end());
  } else {
    fit.poses.resize(views.size());
    for (std::size_t i = 0; i < views.size(); ++i) {
      const Eigen::Matrix3d h = fit_homography(views[i].board, views[i].frame);
      if (i == options.plane_view) fit.homography = h;
      fit.mappings.push_back(Mapping::from_homography(h, options.pixel_aspect));
    }
    return fit;
  }
  for (const auto& pose : fit.poses) fit.mappings.push_back(Mapping::from_lens(*fit.lens, *pose));
  return fit;
}

// Circles where their centres project, not where the centres of their areas were seen.
void take_off_disc_shift(const std::vector<BoardView>& measured, const Fit& fit, std::vector<BoardView>& views) {
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (measured[v].disc_area.empty()) continue;
    std::vector<double> radii;
    for (std::size_t i = 0; i < measured[v].board.size(); ++i) {
      radii.push_back(disc_radius(fit.mappings[v], measured[v].board[i], measured[v].disc_area[i]));
    }
    const double radius = median(radii);
    for (std::size_t i = 0; i < measured[v].board.size(); ++i) {
      const Eigen::Vector2d shift = disc_shift(fit.mappings[v], measured[v].board[i], radius);
      if (shift.allFinite()) views[v].frame[i] = measured[v].frame[i] - shift;
    }
  }
}

Residuals residuals_of(const std::vector<BoardView>& views, const Fit& fit) {
  Residuals residuals;
  double sum = 0.0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const ViewResidual view = residual_of(fit.mappings[i], views[i]);
    residuals.views.push_back(view);
    residuals.points += view.points;
    residuals.worst = std::max(residuals.worst, view.worst);
    sum += view.rms * view.rms * view.points;
  }
  residuals.rms = residuals.points > 0 ? std::sqrt(sum / residuals.points) : 0.0;
  return residuals;
}

// Views that fit much worse than the others usually show a bent board or a wrong corner.
void name_bad_views(Solution& solution) {
  const auto& views = solution.calibration.residuals.views;
  if (views.size() < 3) return;
  std::vector<double> all;
  all.reserve(views.size());
  for (const auto& view : views) all.push_back(view.rms);
  const double usual = median(all);
  for (const auto& view : views) {
    if (view.rms > 3.0 * usual && view.rms > 0.1) {
      solution.warnings.push_back(
          fmt::format("{}: fits {:.1f} times worse than the other views ({:.3f} px): leave it out?", view.name,
                      view.rms / usual, view.rms));
    }
  }
}

// The largest angle between the planes of any two views.
double slant_spread(const std::vector<std::optional<PlanePose>>& poses) {
  double spread = 0.0;
  for (const auto& a : poses) {
    for (const auto& b : poses) {
      const double cosine = std::abs(a->rotation.col(2).dot(b->rotation.col(2)));
      spread = std::max(spread, std::acos(std::min(1.0, cosine)) * degrees);
    }
  }
  return spread;
}

}  // namespace

ViewResidual residual_of(const Mapping& mapping, const BoardView& view) {
  ViewResidual residual;
  residual.name = view.name;
  residual.points = static_cast<int>(view.frame.size());
  double sum = 0.0;
  for (std::size_t i = 0; i < view.frame.size(); ++i) {
    const double distance = (mapping.image_from_plane(view.board[i]) - view.frame[i]).norm();
    sum += distance * distance;
    residual.worst = std::max(residual.worst, distance);
  }
  residual.rms = std::sqrt(sum / std::max(1, residual.points));
  return residual;
}

void judge_lens(const std::vector<BoardView>& views, const SolveOptions& options, Solution& solution) {
  const LensUncertainty& u = *solution.uncertainty;
  const PinholeCamera& c = solution.calibration.lens->camera();
  const char* const advice =
      "tilt the board by 20 to 45 degrees to different sides, or ask for the plane alone (--no-lens)";
  const double spread = slant_spread(solution.poses);
  if (spread < 5.0) {
    throw UsageError(
        fmt::format("the {} views cannot determine the lens: the board stands at the same slant in all of them "
                    "(within {:.1f} degrees); {}",
                    views.size(), spread, advice));
  }
  const double doubt = std::max(u.fx / c.fx, u.fy / c.fy);
  if (!(doubt < 0.05)) {
    throw UsageError(fmt::format(
        "the {} views cannot determine the lens: the focal length would be {:.0f} px give or take {:.0f}; {}",
        views.size(), c.fx, std::max(u.fx, u.fy), advice));
  }
  auto& warnings = solution.warnings;
  if (spread < 15.0) {
    warnings.push_back(
        fmt::format("the slant of the board varies by {:.0f} degrees only: focal length and distances are "
                    "uncertain; {}",
                    spread, advice));
  }
  if (doubt > 0.01) {
    warnings.push_back(fmt::format("the focal length is uncertain: {:.1f} px, standard deviation {:.1f} px ({:.1f}%)",
                                   c.fx, std::max(u.fx, u.fy), 100.0 * doubt));
  }
  if (views.size() < 4) {
    warnings.push_back(fmt::format("{} views are few for a lens: take about ten", views.size()));
  }
  const double centre = std::max(u.cx / options.image_width, u.cy / options.image_height);
  if (centre > 0.01) {
    warnings.push_back(
        fmt::format("the principal point is uncertain: standard deviation {:.1f}, {:.1f} px", u.cx, u.cy));
  }
  if (solution.covered < 0.5 && options.distortion > 0) {
    warnings.push_back(fmt::format("the views cover {:.0f}% of the image: outside of them the distortion is a guess",
                                   100.0 * solution.covered));
  }
  const Lens& lens = *solution.calibration.lens;
  const double right = options.image_width - 1.0;
  const double bottom = options.image_height - 1.0;
  for (const Eigen::Vector2d& corner : {Eigen::Vector2d(0, 0), {right, 0}, {0, bottom}, {right, bottom}}) {
    if (lens.ray_from_pixel(corner).allFinite()) continue;
    warnings.push_back(
        fmt::format("the distortion turns back before the image corner {:.0f},{:.0f}: nothing is found there; "
                    "cover the corners with the board, or ask for fewer coefficients (--distortion)",
                    corner.x(), corner.y()));
    break;
  }
}

Solution solve_views(const std::vector<BoardView>& views, const SolveOptions& options) {
  if (views.empty()) throw UsageError("no picture shows the board");
  if (options.plane_view >= views.size()) throw UsageError("the view of the plane is none of the pictures");
  if (options.image_width < 1 || options.image_height < 1) throw UsageError("the size of the images is missing");
  std::vector<BoardView> corrected = views;
  Fit fit = fit_once(corrected, options);
  if (std::any_of(views.begin(), views.end(), [](const BoardView& view) { return !view.disc_area.empty(); })) {
    // The shift depends little on the fit: twice is enough.
    for (int round = 0; round < 2; ++round) {
      take_off_disc_shift(views, fit, corrected);
      fit = fit_once(corrected, options);
    }
  }
  Solution solution;
  Calibration& calibration = solution.calibration;
  calibration.unit = options.unit;
  calibration.image_width = options.image_width;
  calibration.image_height = options.image_height;
  calibration.made_from = options.made_from;
  calibration.lens = fit.lens;
  calibration.plane = fit.poses[options.plane_view];
  calibration.homography = fit.homography;
  calibration.pixel_aspect = fit.lens ? fit.lens->camera().fy / fit.lens->camera().fx : options.pixel_aspect;
  calibration.residuals = residuals_of(corrected, fit);
  solution.poses = fit.poses;
  solution.uncertainty = fit.uncertainty;
  solution.covered = covered_part(views, options.image_width, options.image_height);
  if (solution.uncertainty) judge_lens(views, options, solution);
  name_bad_views(solution);
  if (!fit.lens && calibration.residuals.views[options.plane_view].rms > 0.3) {
    solution.warnings.push_back(
        fmt::format("{}: the board's points lie {:.2f} px off a flat picture: the lens bends lines; take several views "
                    "to calibrate it",
                    views[options.plane_view].name, calibration.residuals.views[options.plane_view].rms));
  }
  return solution;
}

}  // namespace vsfind
