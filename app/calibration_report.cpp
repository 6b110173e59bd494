#include "app/calibration_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

namespace vsfind {
namespace {

std::string lens_lines(const Solution& solution) {
  const Lens& lens = *solution.calibration.lens;
  const PinholeCamera& c = lens.camera();
  const auto& u = solution.uncertainty;
  const auto give_or_take = [&u](double deviation) { return u ? fmt::format(" +- {:.2f}", deviation) : std::string(); };
  const auto k = std::span(lens.coefficients()).first(static_cast<std::size_t>(lens.coefficient_count()));
  std::string text = fmt::format("lens         fx {:.2f}{}, fy {:.2f}{}, cx {:.2f}{}, cy {:.2f}{} px\n", c.fx,
                                 give_or_take(u ? u->fx : 0.0), c.fy, give_or_take(u ? u->fy : 0.0), c.cx,
                                 give_or_take(u ? u->cx : 0.0), c.cy, give_or_take(u ? u->cy : 0.0));
  text += fmt::format("distortion   {} {:.5f}\n", name(lens.model()), fmt::join(k, " "));
  if (u) text += fmt::format("      +-     {:.5f}\n", fmt::join(u->coefficients, " "));
  return text;
}

std::string plane_lines(const Calibration& calibration, const std::string& plane) {
  std::string text = fmt::format("plane        {}, unit {}\n", plane, calibration.unit);
  const Mapping mapping = mapping_of(calibration);
  const Eigen::Vector2d middle((calibration.image_width - 1) / 2.0, (calibration.image_height - 1) / 2.0);
  const Eigen::Vector2d at = mapping.plane_from_image(middle);
  const double scale = std::sqrt(std::abs(mapping.image_from_plane_jacobian(at).determinant()));
  if (calibration.image_width > 0 && scale > 0.0) {
    text += fmt::format("             {:.5g} {} per pixel in the middle of the image\n", 1.0 / scale, calibration.unit);
  }
  if (calibration.lens && calibration.plane && calibration.residuals.points > 0) {
    const Eigen::Vector3d normal = calibration.plane->rotation.col(2);
    const double slant = std::acos(std::min(1.0, std::abs(normal.z()))) * 180.0 / std::numbers::pi;
    text += fmt::format("             {:.5g} {} from the camera, slant {:.1f} degrees\n",
                        std::abs(normal.dot(calibration.plane->translation)), calibration.unit, slant);
  }
  return text;
}

std::string residual_lines(const Solution& solution) {
  const Residuals& residuals = solution.calibration.residuals;
  if (residuals.points == 0) return {};
  std::string text = fmt::format("residuals    rms {:.4f} px, worst {:.3f} px, {} points\n", residuals.rms,
                                 residuals.worst, residuals.points);
  if (residuals.views.size() > 1) {
    for (const ViewResidual& view : residuals.views) {
      text += fmt::format("             rms {:.4f} px, worst {:.3f} px, {} points: {}\n", view.rms, view.worst,
                          view.points, view.name);
    }
  }
  return text + fmt::format("covered      {:.0f}% of the image\n", 100.0 * solution.covered);
}

}  // namespace

std::string describe(const Solution& solution, const std::string& plane) {
  const Calibration& calibration = solution.calibration;
  std::string text;
  if (calibration.image_width > 0) {
    text += fmt::format(
        "frames       {}x{}, pixel aspect {:.5g}, made from {}\n", calibration.image_width, calibration.image_height,
        calibration.pixel_aspect,
        calibration.made_from == Field::frame ? "whole frames" : fmt::format("{} fields", name(calibration.made_from)));
  } else {
    text += fmt::format("frames       any size, pixel aspect {:.5g}\n", calibration.pixel_aspect);
  }
  if (calibration.lens) text += lens_lines(solution);
  return text + plane_lines(calibration, plane) + residual_lines(solution);
}

}  // namespace vsfind
