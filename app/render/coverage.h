#pragma once
/// @file
/// How much of each small square cell a polygon covers, exactly, one row of cells at a time.

#include <Eigen/Core>
#include <vector>

#include "app/render/scene.h"

namespace vsfind::render {

/// The grid of cells: `per_pixel` cells to a pixel, cell (0,0) at the outer corner (left − 0.5, top − 0.5) of a pixel.
struct CellGrid {
  int per_pixel = 8;
  int left = 0;  ///< frame pixel at which the grid begins
  int top = 0;
  int columns = 0;  ///< cells
  int rows = 0;
};

/// One shape on the grid: the part of its outline in each row of cells.
class ShapeCoverage {
 public:
  /// `contours` in frame pixels.
  ShapeCoverage(const std::vector<Contour>& contours, double grey, const CellGrid& grid);

  [[nodiscard]] int first_row() const { return first_row_; }
  [[nodiscard]] int last_row() const { return first_row_ + static_cast<int>(starts_.size()) - 2; }

  /// Draws the shape over a row of cells. `scratch` holds columns + 2 zeros and holds them again afterwards.
  void paint(int row, std::vector<float>& cells, std::vector<float>& scratch) const;

 private:
  struct Piece {
    double x0, x1;  ///< cells
    double dy;      ///< rows, signed: the direction of the outline
    int row;
  };
  void add_edge(Eigen::Vector2d a, Eigen::Vector2d b);
  void add_piece(int row, double x0, double x1, double dy);

  CellGrid grid_;
  float grey_;
  int first_row_ = 0;
  std::vector<Piece> pieces_;           ///< in the order of rows
  std::vector<std::size_t> starts_{0};  ///< of each row's pieces, from first_row_ on, and the end
};

}  // namespace vsfind::render
