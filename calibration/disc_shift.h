#pragma once
/// @file
/// Perspective and lens shift the centre of a circle's picture from the picture of its centre. For this folder.

#include <Eigen/Core>

#include "calibration/mapping.h"

namespace vsfind {

/// Centre of area of a disc's picture less the picture of its centre, pixels. NaN where a part of it cannot be seen.
[[nodiscard]] Eigen::Vector2d disc_shift(const Mapping& mapping, const Eigen::Vector2d& centre, double radius);

/// Radius in plane units of the disc at `centre` whose picture has this area (to first order).
[[nodiscard]] double disc_radius(const Mapping& mapping, const Eigen::Vector2d& centre, double area);

}  // namespace vsfind
