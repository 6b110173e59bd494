#pragma once
/// @file
/// The turned and scaled copies of a pattern that the exhaustive search tries.

#include <vector>

#include "finder/pose.h"

namespace vsfind {

struct Hypothesis {
  double angle_deg = 0.0;
  double scale_x = 1.0;
  double scale_y = 1.0;
};

/// What is covered, and how densely: no pose of the ranges is more than half a step from a hypothesis.
struct CoarseGrid {
  Range angle_deg;
  Range scale_x;
  Range scale_y;
  bool common_scale = false;
  double angle_step_deg = 0.0;
  double scale_step = 0.0;  ///< ratio of neighbouring scales minus 1
};

/// Every combination, in a fixed order. A range of a full circle or more is covered once round.
[[nodiscard]] std::vector<Hypothesis> hypotheses(const CoarseGrid& grid);

/// How many cells cover each range, and all of them together (as floating-point numbers: they may be very many).
struct GridSize {
  double angles = 1.0;
  double scales_x = 1.0;
  double scales_y = 1.0;  ///< 1 where both axes have a common scale
  [[nodiscard]] double hypotheses() const { return angles * scales_x * scales_y; }
};
/// The size of what hypotheses() gives, without making it.
[[nodiscard]] GridSize size_of(const CoarseGrid& grid);

/// Centres of equal cells that cover the range, none wider than `step`; the middle alone where nothing is searched.
[[nodiscard]] std::vector<double> cell_centres(const Range& range, double step);

}  // namespace vsfind
