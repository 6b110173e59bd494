#pragma once
/// @file
/// A straight edge located to a small part of a pixel.

#include <Eigen/Core>
#include <optional>

#include "acquisition/image_view.h"
#include "calibration/mapping.h"

namespace vsfind {

/// A straight edge on the plane.
struct EdgeLine {
  Eigen::Vector2d point;      ///< on the edge, plane units
  Eigen::Vector2d direction;  ///< of unit length
  double sigma_offset = 0.0;  ///< standard deviation across the edge at `point`, plane units
  double blur = 0.0;          ///< sigma of the edge's Gaussian, plane units, the pixel's own width included
  double step = 0.0;          ///< grey levels across
  double noise = 0.0;         ///< of the residuals, grey levels
};

/// Fits a blurred step, low + step·Φ(d/blur) with d the distance from a straight line and both grey levels free to
/// change along it, to the pixels within `reach` pixels of the segment a–b (pixels of the image), its ends by 15% left
/// out. Least squares over the pixels themselves: nothing is interpolated, and for a symmetric lens the line has no
/// bias. Nothing where there are too few pixels, no edge of `least_step` grey levels (of the image's own), or no fit.
[[nodiscard]] std::optional<EdgeLine> fit_edge_line(const ImageView& image, const Mapping& mapping,
                                                    const Eigen::Vector2d& a, const Eigen::Vector2d& b, double reach,
                                                    double least_step);

/// Where two lines meet; nothing where they are parallel.
[[nodiscard]] std::optional<Eigen::Vector2d> intersection(const EdgeLine& a, const EdgeLine& b);

}  // namespace vsfind
