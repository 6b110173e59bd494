#pragma once
/// @file
/// A plane from points measured by hand: where they are in the image, and where in the world.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "calibration/solve.h"

namespace vsfind {

/// One line of the list.
struct PointPair {
  Eigen::Vector2d image;  ///< pixels of the picture (of a field: its own rows)
  Eigen::Vector2d world;  ///< in the calibration's unit
  int line = 0;           ///< in the file, from 1
};

/// Reads CSV with the header image_x,image_y,world_x,world_y (in any order); empty lines and lines that begin with #
/// are passed over. At most 10000 points. Throws UsageError: `file:line: column: what is wrong`.
[[nodiscard]] std::vector<PointPair> parse_point_pairs(const std::string& text, const std::string& file);

/// The plane through point pairs: exact for four, least squares for more. Of six and more, points that contradict the
/// rest by more than measuring errors would explain are left out and named in the warnings. With `options.lens` the
/// plane's pose before that lens, else a homography. `file` names the list. `used` takes the points that were not
/// left out. Throws UsageError where there are fewer than four, or they are not in general position, naming the lines.
[[nodiscard]] Solution solve_points(const std::vector<PointPair>& pairs, const SolveOptions& options,
                                    const std::string& file, BoardView& used);

}  // namespace vsfind
