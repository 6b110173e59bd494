#include "app/render/coverage.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace vsfind::render {

ShapeCoverage::ShapeCoverage(const std::vector<Contour>& contours, double grey, const CellGrid& grid)
    : grid_(grid), grey_(static_cast<float>(grey)) {
  for (const Contour& contour : contours) {
    for (std::size_t i = 0; i < contour.size(); ++i) {
      const auto cells = [&](const Eigen::Vector2d& p) {
        return Eigen::Vector2d((p.x() + 0.5 - grid.left) * grid.per_pixel, (p.y() + 0.5 - grid.top) * grid.per_pixel);
      };
      add_edge(cells(contour[i]), cells(contour[(i + 1) % contour.size()]));
    }
  }
  if (pieces_.empty()) return;
  std::stable_sort(pieces_.begin(), pieces_.end(), [](const Piece& a, const Piece& b) { return a.row < b.row; });
  first_row_ = pieces_.front().row;
  const int rows = pieces_.back().row - first_row_ + 1;
  starts_.assign(static_cast<std::size_t>(rows) + 1, 0);
  for (const Piece& piece : pieces_) ++starts_[static_cast<std::size_t>(piece.row - first_row_) + 1];
  for (std::size_t i = 1; i < starts_.size(); ++i) starts_[i] += starts_[i - 1];
}

void ShapeCoverage::add_edge(Eigen::Vector2d a, Eigen::Vector2d b) {
  if (a.y() == b.y()) return;
  const double sign = a.y() < b.y() ? 1.0 : -1.0;
  if (sign < 0) std::swap(a, b);
  const double slope = (b.x() - a.x()) / (b.y() - a.y());
  const double begin = std::max(a.y(), 0.0);
  const double end = std::min(b.y(), static_cast<double>(grid_.rows));
  const auto x_at = [&](double y) { return y == b.y() ? b.x() : a.x() + slope * (y - a.y()); };
  for (int row = static_cast<int>(std::floor(begin)); row < end; ++row) {
    const double y0 = std::max(begin, static_cast<double>(row));
    const double y1 = std::min(end, row + 1.0);
    if (y1 > y0) add_piece(row, x_at(y0), x_at(y1), sign * (y1 - y0));
  }
}

void ShapeCoverage::add_piece(int row, double x0, double x1, double dy) {
  // What lies beyond the grid on the left still switches the row on or off at its beginning; on the right it matters
  // not.
  const auto limit = static_cast<double>(grid_.columns);
  for (const double bound : {0.0, limit}) {
    if ((x0 < bound && x1 > bound) || (x0 > bound && x1 < bound)) {
      const double part = (bound - x0) / (x1 - x0);
      add_piece(row, x0, bound, dy * part);
      add_piece(row, bound, x1, dy * (1.0 - part));
      return;
    }
  }
  pieces_.push_back({std::clamp(x0, 0.0, limit), std::clamp(x1, 0.0, limit), dy, row});
}

void ShapeCoverage::paint(int row, std::vector<float>& cells, std::vector<float>& scratch) const {
  if (row < first_row_ || row > last_row()) return;
  const std::size_t begin = starts_[static_cast<std::size_t>(row - first_row_)];
  const std::size_t end = starts_[static_cast<std::size_t>(row - first_row_) + 1];
  if (begin == end) return;
  // scratch becomes the difference of the coverage from cell to cell; touched remembers where.
  struct Touched {
    std::size_t from, to;
  };
  static thread_local std::vector<Touched> touched;
  touched.clear();
  for (std::size_t i = begin; i < end; ++i) {
    const Piece& piece = pieces_[i];
    const double x0 = std::min(piece.x0, piece.x1);
    const double x1 = std::max(piece.x0, piece.x1);
    const auto first = static_cast<std::size_t>(x0);
    const auto last = std::max(first, static_cast<std::size_t>(std::ceil(x1)) - (x1 > 0.0 ? 1U : 0U));
    const auto add = [&](std::size_t cell, double from, double to, double dy) {
      const double right = (from + to) * 0.5 - static_cast<double>(cell);  // part of the cell left of the outline
      scratch[cell] += static_cast<float>(dy * (1.0 - right));
      scratch[cell + 1] += static_cast<float>(dy * right);
    };
    if (first == last) {
      add(first, x0, x1, piece.dy);
    } else {
      const double dy_per_cell = piece.dy / (x1 - x0);
      for (std::size_t cell = first; cell <= last; ++cell) {
        const double from = std::max(x0, static_cast<double>(cell));
        const double to = std::min(x1, static_cast<double>(cell) + 1.0);
        add(cell, from, to, dy_per_cell * (to - from));
      }
    }
    touched.push_back({first, last + 2});
  }
  std::sort(touched.begin(), touched.end(), [](const Touched& a, const Touched& b) { return a.from < b.from; });
  const auto columns = static_cast<std::size_t>(grid_.columns);
  float cover = 0.0F;
  std::size_t done = touched.front().from;
  const auto blend = [&](std::size_t cell, float alpha) {
    cells[cell] += (grey_ - cells[cell]) * std::min(alpha, 1.0F);
  };
  for (const Touched& range : touched) {
    if (range.from > done) {  // constant between outlines: rounding dust of the sum is swept away here
      const float whole = std::abs(cover);
      if (whole > 0.5F && whole > 0.99999F) {
        std::fill(cells.begin() + static_cast<std::ptrdiff_t>(done),
                  cells.begin() + static_cast<std::ptrdiff_t>(std::min(range.from, columns)), grey_);
      } else if (whole > 1e-5F) {
        for (std::size_t cell = done; cell < std::min(range.from, columns); ++cell) blend(cell, whole);
      }
      done = range.from;
    }
    for (; done < range.to; ++done) {
      cover += scratch[done];
      scratch[done] = 0.0F;
      if (done < columns) blend(done, std::abs(cover));
    }
  }
  // An outline cut off at the right border of the grid leaves the row covered to its end.
  if (std::abs(cover) > 1e-5F) {
    for (std::size_t cell = done; cell < columns; ++cell) blend(cell, std::abs(cover));
  }
}

}  // namespace vsfind::render
