#include "tests/calibration/rendered_boards.h"

#include <opencv2/aruco/charuco.hpp>
#include <opencv2/core.hpp>

#include "app/render/patterns.h"
#include "calibration/board_detect.h"
#include "tests/calibration/cameras.h"

namespace vsfind::test {
namespace {

constexpr double light = 210.0;
constexpr double dark = 40.0;

// Sides in short pieces: a lens bends them.
render::Contour square(double left, double top, double side) {
  constexpr int pieces = 8;
  const Eigen::Vector2d corners[] = {{left, top}, {left + side, top}, {left + side, top + side}, {left, top + side}};
  render::Contour contour;
  for (int c = 0; c < 4; ++c) {
    for (int i = 0; i < pieces; ++i) {
      contour.push_back(corners[c] + (corners[(c + 1) % 4] - corners[c]) * i / pieces);
    }
  }
  return contour;
}

void draw_squares(render::Drawing& drawing, int columns, int rows, double pitch) {
  for (int j = -1; j < rows; ++j) {
    for (int i = -1; i < columns; ++i) {
      if ((i + j) % 2 == 0) drawing.shapes.push_back({{square(i * pitch, j * pitch, pitch)}, dark});
    }
  }
}

void draw_markers(render::Drawing& drawing, const BoardSpec& spec) {
  const auto dictionary = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_5X5_100);
  const auto board = cv::aruco::CharucoBoard::create(spec.columns, spec.rows, 1.0F, 0.7F, dictionary);
  constexpr int cells = 7;
  for (std::size_t id = 0; id < board->ids.size(); ++id) {
    const auto& corners = board->objPoints[id];
    const double left = std::min(corners[0].x, corners[2].x), top = std::min(corners[0].y, corners[2].y);
    cv::Mat bits;
    cv::aruco::drawMarker(dictionary, board->ids[id], cells, bits, 1);
    // OpenCV counts from the board's outer corner, we from the first inner one.
    const double x = (left - 1.0) * spec.pitch, y = (top - 1.0) * spec.pitch, cell = 0.7 * spec.pitch / cells;
    drawing.shapes.push_back({{square(x, y, cells * cell)}, dark});
    for (int j = 0; j < cells; ++j) {
      for (int i = 0; i < cells; ++i) {
        if (bits.at<uchar>(j, i) > 0) drawing.shapes.push_back({{square(x + i * cell, y + j * cell, cell)}, light});
      }
    }
  }
}

render::Scene board_scene(const BoardSpec& spec, const Mapping& mapping) {
  render::Scene scene;
  scene.background = light;
  scene.items.push_back({board_drawing(spec), {}});
  scene.frame_from_plane = [mapping](const Eigen::Vector2d& plane) { return mapping.image_from_plane(plane); };
  return scene;
}

}  // namespace

render::Drawing board_drawing(const BoardSpec& spec) {
  render::Drawing drawing;
  const int columns = grid_columns(spec);
  const int rows = grid_rows(spec);
  drawing.width = (columns + 1) * spec.pitch;
  drawing.height = (rows + 1) * spec.pitch;
  if (spec.kind == BoardKind::circles) {
    for (int j = 0; j < rows; ++j) {
      for (int i = 0; i < columns; ++i) {
        drawing.shapes.push_back({{render::circle({i * spec.pitch, j * spec.pitch}, 0.25 * spec.pitch)}, dark});
      }
    }
    return drawing;
  }
  draw_squares(drawing, columns, rows, spec.pitch);
  if (spec.kind == BoardKind::charuco) draw_markers(drawing, spec);
  return drawing;
}

Eigen::Vector2d board_middle(const BoardSpec& spec) {
  return Eigen::Vector2d(grid_columns(spec) - 1, grid_rows(spec) - 1) * spec.pitch / 2.0;
}

std::vector<PlanePose> board_poses(const BoardSpec& spec, int count, double tilt_deg, double distance) {
  std::vector<PlanePose> poses;
  for (int i = 0; i < count; ++i) {
    const double around = 2.0 * std::numbers::pi * i / count;
    PlanePose pose =
        slanted_plane(tilt_deg * std::cos(around), tilt_deg * std::sin(around), 8.0 * std::sin(3.0 * i), distance);
    const double right = i % 2 == 0 ? 0.1 : -0.1;
    const double down = i / 2 % 2 == 0 ? 0.08 : -0.08;
    if (i + 1 < count) pose.translation.head<2>() = distance * Eigen::Vector2d(right, down);
    pose.translation -= pose.rotation.leftCols<2>() * board_middle(spec);
    poses.push_back(pose);
  }
  return poses;
}

render::Picture board_picture(const BoardSpec& spec, const Mapping& mapping, Field lines, std::uint64_t seed) {
  render::Sensor sensor;
  sensor.seed = seed;
  return render::develop(render::expose(board_scene(spec, mapping), 0.7, lines), sensor);
}

render::Picture woven_picture(const BoardSpec& spec, const Mapping& top, const Mapping& bottom) {
  return render::develop(render::weave(render::expose(board_scene(spec, top), 0.7, Field::top),
                                       render::expose(board_scene(spec, bottom), 0.7, Field::bottom)),
                         render::Sensor{});
}

}  // namespace vsfind::test
