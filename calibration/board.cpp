#include "calibration/board.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "acquisition/errors.h"
#include "calibration/board_detect.h"
#include "calibration/corner_refine.h"
#include "calibration/disc_centre.h"
#include "calibration/plane_fit.h"

namespace vsfind {
namespace {

// Fields that differ by more saw the board in different places; a still one is seen to 0.1 pixel even when noisy.
constexpr double still_pixels = 0.3;

int parse_count(std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() ? value : -1;
}

// Columns or rows counted from the other end, or exchanged, until the board stands as board.h says.
void turn_upright(std::vector<GridPoint>& points, const BoardSpec& spec) {
  const int columns = grid_columns(spec);
  const int rows = grid_rows(spec);
  const auto slopes = [&points]() -> Eigen::Matrix2d {
    // Least squares of position over (column, row): columns are the steps along a row and along a column.
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Matrix<double, 3, 2> right = Eigen::Matrix<double, 3, 2>::Zero();
    for (const GridPoint& p : points) {
      const Eigen::Vector3d row(p.column, p.row, 1.0);
      normal += row * row.transpose();
      right += row * p.frame.transpose();
    }
    return (normal.inverse() * right).topRows<2>().transpose();
  };
  if (slopes().determinant() < 0.0) {
    for (GridPoint& p : points) {
      if (spec.kind == BoardKind::charuco)
        p.row = rows - 1 - p.row;
      else
        p.column = columns - 1 - p.column;
    }
  }
  if (spec.kind == BoardKind::charuco) return;
  if (columns == rows && std::abs(slopes()(0, 0)) < std::abs(slopes()(1, 0))) {
    for (GridPoint& p : points) {
      const int column = p.column;
      p.column = p.row;
      p.row = columns - 1 - column;
    }
  }
  // Right or down: the choice turns over where x runs along the other diagonal, where boards seldom lie.
  if (slopes().col(0).sum() > 0.0) return;
  for (GridPoint& p : points) {
    p.column = columns - 1 - p.column;
    p.row = rows - 1 - p.row;
  }
}

struct Measured {
  std::vector<GridPoint> points;
  std::vector<double> areas;
  std::vector<bool> good;
};

// Every point of the grid to a fraction of a pixel, from the lines of `field` that `image` holds.
Measured measure(const ImageView& image, Field field, const BoardSpec& spec, const DetectedGrid& grid) {
  std::vector<Eigen::Vector2d> plane, frame;
  for (const GridPoint& p : grid.points) {
    plane.emplace_back(p.column, p.row);
    frame.push_back(p.frame);
  }
  const Mapping rough = Mapping::from_homography(fit_homography(plane, frame));
  Measured result{grid.points, {}, std::vector<bool>(grid.points.size(), false)};
  for (std::size_t i = 0; i < grid.points.size(); ++i) {
    const Eigen::Matrix2d steps = rough.image_from_plane_jacobian(plane[i]);
    const double spacing = std::min(steps.col(0).norm(), steps.col(1).norm());
    if (spec.kind == BoardKind::circles) {
      const auto disc = measure_disc(image, field, grid.points[i].frame, 0.55 * spacing);
      result.good[i] = disc.has_value();
      result.areas.push_back(disc ? disc->area : 0.0);
      if (disc) result.points[i].frame = disc->centre;
      continue;
    }
    // A marker's corner stands at √½ of the free part from the chessboard's.
    const double free = std::min(0.45, 0.7 * grid.free_part);
    CornerGuess guess{grid.points[i].frame, steps.col(0), steps.col(1), std::clamp(free * spacing, 3.0, 7.0)};
    result.good[i] = refine_corner(image, field, guess);
    if (result.good[i]) result.points[i].frame = guess.position;
  }
  return result;
}

double median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// How far apart the two fields of a frame see the board: the median over its points, NaN where they cannot tell.
double field_distance(const ImageView& image, const BoardSpec& spec, const DetectedGrid& in_frame) {
  const ImageView top_lines = field_view(image, Field::top);
  const ImageView bottom_lines = field_view(image, Field::bottom);
  if (!in_frame.points.empty()) {
    const Measured top = measure(top_lines, Field::top, spec, in_frame);
    const Measured bottom = measure(bottom_lines, Field::bottom, spec, in_frame);
    std::vector<double> distances;
    for (std::size_t i = 0; i < top.points.size(); ++i) {
      if (top.good[i] && bottom.good[i]) distances.push_back((top.points[i].frame - bottom.points[i].frame).norm());
    }
    if (2 * distances.size() > top.points.size()) return median(distances);
  }
  // Combed too far: each field by itself.
  const DetectedGrid top = detect_grid(top_lines, Field::top, spec);
  const DetectedGrid bottom = detect_grid(bottom_lines, Field::bottom, spec);
  std::vector<double> distances;
  for (const GridPoint& a : top.points) {
    for (const GridPoint& b : bottom.points) {
      if (a.column == b.column && a.row == b.row) distances.push_back((a.frame - b.frame).norm());
    }
  }
  return median(distances);
}

}  // namespace

BoardSpec parse_board(const std::string& text) {
  BoardSpec spec;
  const std::size_t colon = text.find(':');
  const std::string kind = text.substr(0, colon);
  const std::size_t cross = colon == std::string::npos ? colon : text.find('x', colon);
  const std::string problem = "board '" + text.substr(0, 64) + "': ";
  const char* const allowed = " (allowed: chessboard:COLSxROWS, circles:COLSxROWS, charuco:COLSxROWS)";
  if (kind == "chessboard") {
    spec.kind = BoardKind::chessboard;
  } else if (kind == "circles") {
    spec.kind = BoardKind::circles;
  } else if (kind == "charuco") {
    spec.kind = BoardKind::charuco;
  } else {
    throw UsageError(problem + "not a known kind" + allowed);
  }
  if (cross == std::string::npos) throw UsageError(problem + "its size is missing" + allowed);
  spec.columns = parse_count(std::string_view(text).substr(colon + 1, cross - colon - 1));
  spec.rows = parse_count(std::string_view(text).substr(cross + 1));
  if (spec.columns < 3 || spec.rows < 3 || spec.columns > 100 || spec.rows > 100) {
    throw UsageError(problem + "columns and rows must be whole numbers from 3 to 100");
  }
  return spec;
}

std::optional<BoardView> find_board(const ImageView& image, Field field, const BoardSpec& spec,
                                    const std::string& name) {
  DetectedGrid grid = detect_grid(image, field, spec);
  const bool interlaced = field == Field::frame && image.height >= 32;
  const double apart = interlaced ? field_distance(image, spec, grid) : 0.0;
  if (apart > still_pixels) {
    throw UsageError(fmt::format(
        "{}: the two fields of this interlaced picture see the board {:.1f} pixels apart: it moved; hold it still, or "
        "calibrate on single fields (--field top or bottom)",
        name, apart));
  }
  if (grid.points.empty()) return std::nullopt;
  turn_upright(grid.points, spec);
  const Measured measured = measure(image, field, spec, grid);
  // A corner that cannot be fitted lies at the image border or under a reflection, and the detector's place for it is
  // not to be trusted either. Only where squares are too small to fit any, all keep the detector's places.
  const auto fitted = static_cast<std::size_t>(std::count(measured.good.begin(), measured.good.end(), true));
  const bool too_small = spec.kind == BoardKind::chessboard && 2 * fitted < measured.points.size();
  BoardView view;
  view.name = name;
  for (std::size_t i = 0; i < measured.points.size(); ++i) {
    const GridPoint& p = measured.points[i];
    if (!measured.good[i] && !too_small) continue;
    view.frame.push_back(p.frame);
    view.board.emplace_back(p.column * spec.pitch, p.row * spec.pitch);
    if (spec.kind == BoardKind::circles) view.disc_area.push_back(measured.areas[i]);
  }
  if (view.frame.size() < 6) return std::nullopt;
  return view;
}

}  // namespace vsfind
