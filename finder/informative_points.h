#pragma once
/// @file
/// Which points determine a pose best.

#include <Eigen/Core>
#include <vector>

#include "finder/fit.h"
#include "finder/pattern.h"

namespace vsfind {

/// Derivatives of a point's value by (a, b, angle, scale_x, scale_y), those that are free, at the pose of training;
/// where the freedom includes blur, then by gain, offset and blur, which are fitted too and must not be taken for a
/// pose.
[[nodiscard]] Eigen::VectorXd pose_derivatives(const PatternPoint& point, const Freedom& freedom);

/// Chooses up to `count` of the candidates, in order of choice, none nearer than `spacing` pattern pixels to another.
/// Each choice is the one that adds most to the determinant of the pose's information, that of Σ j·jᵀ with gain, offset
/// and blur eliminated (D_s-optimal design, by leverage jᵀ·M⁻¹·j less that of the eliminated ones alone). Among points
/// of like worth the choice is spread evenly; where position alone is free, to which it makes no difference where a
/// point lies, no cell of an 8 × 8 grid gives much more than its share of the leverage. With `spread` no cell of an 8 ×
/// 8 grid over the candidates gives more than its even share while others have points left.
[[nodiscard]] std::vector<std::size_t> choose_informative(const std::vector<PatternPoint>& candidates,
                                                          const Freedom& freedom, std::size_t count, double spacing,
                                                          bool spread);

/// For (a, b, angle, scale_x, scale_y); 1 where one is not free.
using PointInflation = Eigen::Matrix<double, 5, 1>;

/// How much neighbouring points, which read the same pixels, enlarge the variances over those of independent points:
/// from Σ j·jᵀ·ρ over pairs of points, where the noise of two readings at distance d through the same Gaussian has the
/// correlation ρ = exp(−d²/4σ²).
[[nodiscard]] PointInflation inflation_of(const std::vector<PatternPoint>& points, const Freedom& freedom);

}  // namespace vsfind
