#pragma once
/// @file
/// What a finder must answer for a rendered scene.

#include <Eigen/Core>
#include <vector>

#include "app/render/scene.h"
#include "finder/pose.h"

namespace vsfind::render {

/// The pose that a finder must report, in the contract's words, for a drawing that lay at `train` when it was trained
/// and lies at `scene` now. `origin`: the pattern's origin in plane coordinates of the training picture.
/// The two are related by a pose only if the training angle is 0 or each of the two has one scale for both axes.
[[nodiscard]] Pose expected_pose(const Pose& train, const Pose& scene, const Eigen::Vector2d& origin);

/// Centre of an ROI in pixels: X + (W − 1)/2.
[[nodiscard]] Eigen::Vector2d roi_centre(const Roi& roi);

/// An angle difference brought into (−180, 180].
[[nodiscard]] double angle_difference_deg(double a, double b);

/// Whether a point lies inside the shape (even number of crossings: outside).
[[nodiscard]] bool inside(const Shape& shape, const Eigen::Vector2d& point);

/// Part (0 … 1) of the drawing's box that `cover`, in the same drawing coordinates, hides.
[[nodiscard]] double hidden_part(const Drawing& drawing, const Drawing& cover);

/// Part (0 … 1) of the item's box that lies outside the picture.
[[nodiscard]] double outside_part(const Scene& scene, const Item& item);

}  // namespace vsfind::render
