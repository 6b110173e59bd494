#pragma once
/// @file
/// A calibration in words.

#include <string>

#include "calibration/solve.h"

namespace vsfind {

/// A few lines: lens with its standard deviations, plane, residuals of every view, covered part of the image. `plane`
/// says what the plane is.
[[nodiscard]] std::string describe(const Solution& solution, const std::string& plane);

}  // namespace vsfind
