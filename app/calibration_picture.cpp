#include "app/calibration_picture.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "app/drawing.h"
#include "app/frame_searcher.h"
#include "app/overlay.h"

namespace vsfind {
namespace {

const Colour white(255, 255, 255);
const Colour grid_colour(230, 190, 80);
const Colour ring_colour(80, 230, 80);
const Colour residual_colour(30, 140, 255);
const Colour x_colour(70, 70, 255);
const Colour y_colour(80, 255, 120);

constexpr double text_height = 11.0;

/// 1, 2 or 5 times a power of ten, at most `value`.
double round_number(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double digit : {5.0, 2.0}) {
    if (digit * power <= value) return digit * power;
  }
  return power;
}

struct Canvas {
  cv::Mat picture;
  double zoom = 1.0;
  Eigen::Vector2d frame_size;

  Eigen::Vector2d at(const Eigen::Vector2d& frame) const {
    return {(frame.x() + 0.5) * zoom - 0.5, (frame.y() + 0.5) * zoom - 0.5};
  }
  bool shows(const Eigen::Vector2d& frame) const {
    return frame.x() >= -1.0 && frame.y() >= -1.0 && frame.x() <= frame_size.x() && frame.y() <= frame_size.y();
  }
};

Canvas make_canvas(const ImageView& image, Field field, const Calibration& calibration) {
  constexpr double wanted_width = 1280.0;
  cv::Mat frame(std::max(1, calibration.image_height), std::max(1, calibration.image_width), CV_8UC3,
                cv::Scalar::all(110));
  if (!image.empty()) frame = overlay_canvas(grey_picture(image), field);
  Canvas canvas;
  canvas.frame_size = {frame.cols, frame.rows};
  canvas.zoom = std::clamp(std::round(wanted_width / frame.cols), 1.0, 4.0);
  cv::resize(frame, canvas.picture, {}, canvas.zoom, canvas.zoom, cv::INTER_CUBIC);
  return canvas;
}

/// The plane's rectangle that the picture shows, kept near the points where the horizon would stretch it without end.
struct Extent {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high = -low;
  void add(const Eigen::Vector2d& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
};

Extent shown_extent(const Canvas& canvas, const Mapping& mapping, const BoardView& view) {
  Extent points;
  for (const auto& p : view.board) points.add(p);
  const Eigen::Vector2d margin = 5.0 * (points.high - points.low);
  Extent shown = points;
  constexpr int steps = 40;
  for (int i = 0; i <= steps; ++i) {
    for (int j = 0; j <= steps; ++j) {
      const Eigen::Vector2d frame(canvas.frame_size.x() * i / steps - 0.5, canvas.frame_size.y() * j / steps - 0.5);
      const Eigen::Vector2d plane = mapping.plane_from_image(frame);
      if (plane.allFinite()) shown.add(plane.cwiseMax(points.low - margin).cwiseMin(points.high + margin));
    }
  }
  return shown;
}

void draw_curve(Canvas& canvas, const Mapping& mapping, const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  constexpr int pieces = 120;
  Eigen::Vector2d last = Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  for (int i = 0; i <= pieces; ++i) {
    const Eigen::Vector2d frame = mapping.image_from_plane(Eigen::Vector2d(from + (to - from) * i / pieces));
    if (canvas.shows(frame) && canvas.shows(last)) {
      draw_line(canvas.picture, canvas.at(last), canvas.at(frame), grid_colour);
    }
    last = frame;
  }
}

double draw_grid(Canvas& canvas, const Mapping& mapping, const BoardView& view) {
  constexpr double wanted_pixels = 60.0;
  constexpr double most_lines = 200.0;
  const Extent extent = shown_extent(canvas, mapping, view);
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const auto& p : view.board) middle += p / static_cast<double>(view.board.size());
  const double scale = std::sqrt(std::abs(mapping.image_from_plane_jacobian(middle).determinant())) * canvas.zoom;
  const double least = (extent.high - extent.low).maxCoeff() / most_lines;
  const double step = round_number(std::max(2.0 * wanted_pixels / scale, 2.0 * least));
  for (int axis = 0; axis < 2; ++axis) {
    for (double n = std::ceil(extent.low[axis] / step); n * step <= extent.high[axis]; n += 1.0) {
      Eigen::Vector2d from = extent.low;
      Eigen::Vector2d to = extent.high;
      from[axis] = to[axis] = n * step;
      draw_curve(canvas, mapping, from, to);
    }
  }
  const Eigen::Vector2d origin = mapping.image_from_plane(Eigen::Vector2d(0.0, 0.0));
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector2d tip = mapping.image_from_plane(Eigen::Vector2d(step * Eigen::Vector2d::Unit(axis)));
    if (!canvas.shows(origin) || !tip.allFinite()) continue;
    draw_arrow(canvas.picture, canvas.at(origin), canvas.at(tip), axis == 0 ? x_colour : y_colour, 12.0);
    draw_text(canvas.picture, canvas.at(tip) + Eigen::Vector2d(6.0, -6.0), axis == 0 ? "x" : "y", text_height,
              axis == 0 ? x_colour : y_colour);
  }
  return step;
}

/// So much that the usual residual can be seen, and is not taken for another point's.
double draw_residuals(Canvas& canvas, const Mapping& mapping, const BoardView& view, double rms) {
  constexpr double wanted_pixels = 15.0;
  constexpr double most = 1000.0;  // an exact fit has none to show
  const double magnified = std::clamp(round_number(wanted_pixels / (canvas.zoom * std::max(rms, 1e-6))), 1.0, most);
  for (std::size_t i = 0; i < view.frame.size(); ++i) {
    const Eigen::Vector2d residual = mapping.image_from_plane(view.board[i]) - view.frame[i];
    const Eigen::Vector2d at = canvas.at(view.frame[i]);
    std::vector<Eigen::Vector2d> ring;
    ring.reserve(16);
    for (int k = 0; k < 16; ++k)
      ring.emplace_back(at + 4.5 * Eigen::Vector2d(std::cos(k * 0.3927), std::sin(k * 0.3927)));
    draw_outline(canvas.picture, ring, ring_colour);
    const double longest = canvas.frame_size.norm();
    if (residual.allFinite() && residual.norm() * magnified < longest) {
      draw_line(canvas.picture, at, at + residual * magnified * canvas.zoom, residual_colour, 2);
    }
  }
  return magnified;
}

}  // namespace

cv::Mat calibration_picture(const ImageView& image, Field field, const Calibration& calibration,
                            const BoardView& view) {
  Canvas canvas = make_canvas(image, field, calibration);
  const Mapping mapping = mapping_of(calibration);
  double sum = 0.0;
  for (std::size_t i = 0; i < view.frame.size(); ++i) {
    sum += (mapping.image_from_plane(view.board[i]) - view.frame[i]).squaredNorm();
  }
  const double rms = view.frame.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(view.frame.size()));
  const double step = draw_grid(canvas, mapping, view);
  const double magnified = draw_residuals(canvas, mapping, view, rms);
  const std::array<std::string, 2> legend{
      fmt::format("{}: {} points, rms {:.3f} px; residuals x{:g}", std::filesystem::path(view.name).filename().string(),
                  view.frame.size(), rms, magnified),
      fmt::format("grid {:g} {}", step, calibration.unit)};
  double y = 24.0;
  for (const std::string& line : legend) {
    draw_text(canvas.picture, {10.0, y}, line, text_height, white);
    y += 22.0;
  }
  return canvas.picture;
}

}  // namespace vsfind
