#pragma once
/// @file
/// A pattern made ready for the search: its points as arrays, and what can be computed once.

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "finder/coarse_search.h"
#include "finder/fit.h"
#include "finder/pattern_spline.h"
#include "finder/polygon.h"
#include "finder/search.h"

namespace vsfind {

struct PreparedPattern {
  std::shared_ptr<const Pattern> pattern;
  CoarsePoints search;
  PointArrays climb;                ///< the same points, for climbing at the top level
  std::vector<PointArrays> follow;  ///< by level, 0 … top_level; level 0 may be empty
  PointArrays refine;               ///< then the outline points
  int trusted = 0;                  ///< how many of them are refine points
  PointArrays verify;
  PatternSpline spline;  ///< for single fields
  std::vector<Hypothesis> hypotheses;
  Range angle_deg;  ///< searched
  Range scale_x;
  Range scale_y;
  Freedom freedom;
  /// How much neighbouring points, which read the same pixels, enlarge the variances of (a, b, angle, scale_x, scale_y)
  /// over those of independent points.
  Eigen::Matrix<double, 5, 1> inflation;

  PreparedPattern(std::shared_ptr<const Pattern> source, const SearchOptions& options);

  /// What is fitted at full resolution.
  [[nodiscard]] Freedom fine_freedom() const;
  /// Whether a pose found lies in the ranges searched, or a little outside: the last half step is refined like any
  /// other.
  [[nodiscard]] bool in_range(const Pose& pose) const;
  /// Corners of the outline at a pose, plane coordinates.
  [[nodiscard]] Polygon outline(const Pose& pose) const;
};

}  // namespace vsfind
