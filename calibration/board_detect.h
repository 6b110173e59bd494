#pragma once
/// @file
/// The detectors of OpenCV behind plain types. For board.cpp, not a public door.

#include <Eigen/Core>
#include <vector>

#include "acquisition/image_view.h"
#include "calibration/board.h"

namespace vsfind {

/// A corner or circle of the board, frame pixels, to a pixel or better.
struct GridPoint {
  int column = 0;
  int row = 0;
  Eigen::Vector2d frame = Eigen::Vector2d::Zero();
};

struct DetectedGrid {
  std::vector<GridPoint> points;  ///< empty: no board
  double free_part = 1.0;  ///< part of a square around a corner that nothing else covers (ChArUco: up to the marker)
};

/// How many columns and rows of points the board has.
[[nodiscard]] int grid_columns(const BoardSpec& spec);
[[nodiscard]] int grid_rows(const BoardSpec& spec);

[[nodiscard]] DetectedGrid detect_grid(const ImageView& image, Field field, const BoardSpec& spec);

}  // namespace vsfind
