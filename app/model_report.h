#pragma once
/// @file
/// A trained pattern in words, for people.

#include <string>

#include "finder/pattern.h"

namespace vsfind {

/// What training made of the pattern: size, ranges, levels and points, expected accuracy. Several lines, each ended.
[[nodiscard]] std::string describe(const Pattern& pattern);

/// The points of all sets as CSV: level,x,y,use,value,gradient_x,gradient_y, in full-resolution pattern pixels from
/// the origin.
[[nodiscard]] std::string points_csv(const Pattern& pattern);

}  // namespace vsfind
