#include "app/overlay.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <opencv2/imgproc.hpp>

#include "acquisition/errors.h"
#include "app/drawing.h"
#include "app/result_row.h"

namespace vsfind {
namespace {

const Colour origin_x_colour(60, 60, 255);
const Colour origin_y_colour(255, 160, 60);

/// One colour per pattern, told apart on grey.
Colour pattern_colour(std::size_t index) {
  static const std::array<Colour, 6> colours{Colour(80, 255, 80),  Colour(0, 200, 255),  Colour(255, 120, 255),
                                             Colour(255, 255, 80), Colour(80, 160, 255), Colour(180, 255, 180)};
  return colours[index % colours.size()];
}

/// The points that the final pose rests on.
std::vector<const PatternPoint*> shown_points(const Pattern& pattern) {
  std::vector<const PatternPoint*> points;
  for (const auto& set : pattern.sets) {
    if (set.use != PointUse::refine && set.use != PointUse::outline) continue;
    for (const auto& point : set.points) points.push_back(&point);
  }
  return points;
}

void draw_match(cv::Mat& canvas, const Pattern& pattern, const Match& match, const Mapping& frame_mapping,
                const Colour& colour) {
  const auto in_frame = [&](double x, double y) {
    return frame_mapping.image_from_plane(plane_from_pattern(match.pose, pattern.pitch * Eigen::Vector2d(x, y)));
  };
  draw_outline(canvas, pattern_outline(pattern, match.pose, frame_mapping), colour);

  // Half transparent: there may be hundreds, and the part is to be seen beneath them.
  constexpr double point_arm = 1.0;
  const Colour point_colour(0, 230, 255);
  cv::Mat with_points = canvas.clone();
  for (const PatternPoint* point : shown_points(pattern)) {
    draw_plus(with_points, in_frame(point->x, point->y), point_arm, point_colour);
  }
  cv::addWeighted(with_points, 0.5, canvas, 0.5, 0.0, canvas);

  const double axis = std::max(10.0, 0.25 * std::min(pattern.width, pattern.height));
  const Eigen::Vector2d origin = in_frame(0.0, 0.0);
  draw_arrow(canvas, origin, in_frame(axis, 0.0), origin_x_colour, 6.0);
  draw_arrow(canvas, origin, in_frame(0.0, axis), origin_y_colour, 6.0);
  draw_plus(canvas, origin, 5.0, Colour(0, 0, 0), 3);
  draw_plus(canvas, origin, 4.0, Colour(255, 255, 255));
}

/// Lines of text from the top left corner on, as long as they fit.
class TextColumn {
 public:
  explicit TextColumn(cv::Mat& canvas) : canvas_(canvas) {}
  void line(const std::string& text, const Colour& colour) {
    constexpr double margin = 6.0;
    constexpr double height = 9.0;
    constexpr double spacing = 1.7;
    const double room = canvas_.cols - 2.0 * margin;
    const double wanted = text_width(text, height);
    const double fitting = wanted > room ? std::max(4.0, height * room / wanted) : height;
    y_ += height * spacing;
    if (y_ < canvas_.rows) draw_text(canvas_, {margin, y_}, text, fitting, colour);
  }

 private:
  cv::Mat& canvas_;
  double y_ = 0.0;
};

}  // namespace

cv::Mat overlay_canvas(const GreyPicture& grey, Field field) {
  const cv::Mat rows(grey.height, grey.width, CV_8UC1, const_cast<std::uint8_t*>(grey.pixels.data()));
  cv::Mat frame;
  if (field == Field::frame) {
    frame = rows;
  } else {
    frame.create(grey.height * 2, grey.width, CV_8UC1);
    const int first = first_line(field);
    for (int y = 0; y < frame.rows; ++y) {
      // Field rows above and below this frame row; the same one where it is a row of the field or lies at the border.
      const int above = std::clamp((y - first) >> 1, 0, grey.height - 1);
      const int below = std::clamp((y - first + 1) >> 1, 0, grey.height - 1);
      cv::addWeighted(rows.row(above), 0.5, rows.row(below), 0.5, 0.0, frame.row(y));
    }
  }
  cv::Mat canvas;
  cv::cvtColor(frame, canvas, cv::COLOR_GRAY2BGR);
  return canvas;
}

std::vector<Eigen::Vector2d> pattern_outline(const Pattern& pattern, const Pose& pose, const Mapping& frame_mapping) {
  constexpr int pieces = 16;
  const double right = pattern.left + pattern.width;
  const double bottom = pattern.top + pattern.height;
  const std::array<Eigen::Vector2d, 5> corners{
      Eigen::Vector2d(pattern.left, pattern.top), Eigen::Vector2d(right, pattern.top), Eigen::Vector2d(right, bottom),
      Eigen::Vector2d(pattern.left, bottom), Eigen::Vector2d(pattern.left, pattern.top)};
  std::vector<Eigen::Vector2d> outline;
  for (std::size_t side = 0; side + 1 < corners.size(); ++side) {
    for (int i = 0; i < pieces; ++i) {
      const Eigen::Vector2d p = corners[side] + (corners[side + 1] - corners[side]) * (static_cast<double>(i) / pieces);
      outline.push_back(frame_mapping.image_from_plane(plane_from_pattern(pose, pattern.pitch * p)));
    }
  }
  return outline;
}

void draw_matches(cv::Mat& canvas, const PictureResult& picture,
                  const std::vector<std::shared_ptr<const Pattern>>& patterns, const Mapping& frame_mapping) {
  TextColumn text(canvas);
  for (std::size_t p = 0; p < picture.patterns.size(); ++p) {
    const Colour colour = pattern_colour(p);
    const Pattern& pattern = *patterns[p];
    const auto& matches = picture.patterns[p].matches;
    if (matches.empty()) text.line(pattern.name + ": not found", colour);
    for (std::size_t i = 0; i < matches.size(); ++i) {
      const Match& match = matches[i];
      draw_match(canvas, pattern, match, frame_mapping, colour);
      std::string line =
          fmt::format("{} {}: score {}  x {}  y {}  angle {} deg", pattern.name, i, fixed(match.score, 3),
                      fixed(match.pose.x, 3), fixed(match.pose.y, 3), fixed(match.pose.angle_deg, 3));
      if (pattern.scale_x.searched() || pattern.scale_y.searched()) {
        line += fmt::format("  scale {:.4f} {:.4f}", match.pose.scale_x, match.pose.scale_y);
      }
      text.line(line, colour);
      if (matches.size() > 1) {
        draw_text(canvas, match.frame_position + Eigen::Vector2d(8.0, -8.0), fmt::format("{}", i), 9.0, colour);
      }
    }
  }
}

std::string overlay_name(std::size_t source_index, std::uint64_t frame, Field field, std::size_t index_in_frame) {
  if (field == Field::frame) return fmt::format("s{}-{:08}-frame.png", source_index, frame);
  return fmt::format("s{}-{:08}-{}-{}.png", source_index, frame, index_in_frame == 0 ? 'a' : 'b', name(field));
}

OverlayWriter::OverlayWriter(std::string folder) : folder_(std::move(folder)) {
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error) throw IoError(folder_ + ": the folder cannot be made: " + error.message());
  if (::access(folder_.c_str(), W_OK | X_OK) != 0) {
    throw IoError(folder_ + ": the folder cannot be written to: " + std::strerror(errno));
  }
}

void OverlayWriter::write(const FrameResult& result, const std::vector<std::shared_ptr<const Pattern>>& patterns,
                          const Mapping& frame_mapping) const {
  const Mapping mapping = frame_mapping.for_field(Field::frame);
  for (std::size_t i = 0; i < result.pictures.size(); ++i) {
    const auto& picture = result.pictures[i];
    if (picture.grey.pixels.empty()) continue;
    cv::Mat canvas = overlay_canvas(picture.grey, picture.field);
    draw_matches(canvas, picture, patterns, mapping);
    write_png(folder_ + "/" + overlay_name(result.source_index, result.info.sequence, picture.field, i), canvas);
  }
}

}  // namespace vsfind
