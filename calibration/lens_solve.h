#pragma once
/// @file
/// OpenCV's calibrateCamera behind plain types. For solve.cpp, not a public door.

#include <vector>

#include "calibration/solve.h"

namespace vsfind {

struct SolvedLens {
  Lens lens;
  std::vector<PlanePose> poses;
  LensUncertainty uncertainty;
};

/// Lens and poses with the least sum of squared distances in the frame. Throws UsageError where it does not converge.
[[nodiscard]] SolvedLens solve_lens(const std::vector<BoardView>& views, const SolveOptions& options);

/// Part of the image that lies within the outlines of the views' points, 0 … 1.
[[nodiscard]] double covered_part(const std::vector<BoardView>& views, int width, int height);

}  // namespace vsfind
