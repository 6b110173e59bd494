#pragma once
/// @file
/// A plane from points of known plane position: by a homography, or by its pose before a known lens.

#include <Eigen/Core>
#include <span>

#include "calibration/lens.h"
#include "calibration/mapping.h"

namespace vsfind {

/// The homography out = H(plane) with the least sum of squared distances in `out` (exact for four points), scaled to
/// norm 1 and positive third component at all points. Normalized direct linear transformation (Hartley 1997), then
/// Gauss-Newton. Throws UsageError where fewer than four points are given, where they do not determine it (too many on
/// one line), and where no camera can see them so (they would lie on both sides of the horizon).
[[nodiscard]] Eigen::Matrix3d fit_homography(std::span<const Eigen::Vector2d> plane,
                                             std::span<const Eigen::Vector2d> out);

/// The pose of the plane before the lens with the least sum of squared distances in frame pixels. At least four points.
/// Throws UsageError as fit_homography() does, and where the lens model does not reach a point.
[[nodiscard]] PlanePose fit_plane_pose(const Lens& lens, std::span<const Eigen::Vector2d> plane,
                                       std::span<const Eigen::Vector2d> frame);

}  // namespace vsfind
