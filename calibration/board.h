#pragma once
/// @file
/// Calibration boards in pictures: chessboards, grids of circles, ChArUco boards.
///
/// Board coordinates, in the board's unit: (0, 0) is the first inner corner (or circle), x along the columns, y along
/// the rows, turned so that seen from the camera positive angles go from x to y clockwise as in the image. A chessboard
/// or circle grid looks the same after half a turn: x is then taken to point to the right in the picture, or down where
/// it is nearer to upright. A ChArUco board knows its own top left.

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/image_view.h"

namespace vsfind {

enum class BoardKind { chessboard, circles, charuco };

struct BoardSpec {
  BoardKind kind = BoardKind::chessboard;
  int columns = 0;  ///< inner corners of a chessboard, circles of a grid, squares of a ChArUco board
  int rows = 0;
  double pitch = 1.0;  ///< side of a square, distance of circles: in the board's unit
};

/// Reads `chessboard:COLSxROWS`, `circles:COLSxROWS` or `charuco:COLSxROWS`. The pitch stays 1. Throws UsageError.
[[nodiscard]] BoardSpec parse_board(const std::string& text);

/// The board in one picture. Positions are frame pixels even where the picture is a single field.
struct BoardView {
  std::string name;
  std::vector<Eigen::Vector2d> frame;
  std::vector<Eigen::Vector2d> board;
  std::vector<double> disc_area;  ///< of circles: area in the frame, square pixels, one per point; else empty
};

/// Finds the board in a picture that holds the lines of `field`. Empty where it is not there (a ChArUco board: fewer
/// than six of its corners). Corners come from OpenCV's sector-based detector (or its older one, or the ArUco markers)
/// and are then fitted to the grey values; circles are grey-weighted centres of area. Throws UsageError where the
/// picture holds the board twice over: a frame whose two fields saw it in different places (a moving board in an
/// interlaced picture). `name` is the picture's, for complaints and reports.
[[nodiscard]] std::optional<BoardView> find_board(const ImageView& image, Field field, const BoardSpec& spec,
                                                  const std::string& name);

}  // namespace vsfind
