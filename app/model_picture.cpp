#include "app/model_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <opencv2/imgproc.hpp>

#include "acquisition/errors.h"
#include "app/drawing.h"

namespace vsfind {
namespace {

const Colour black(0, 0, 0);
const Colour white(255, 255, 255);
const Colour red(60, 60, 255);
const Colour blue(255, 160, 60);
const Colour yellow(60, 230, 255);

void draw_coarse(cv::Mat& picture, const Eigen::Vector2d& at) {
  draw_cross(picture, at, 5.0, white, 4);
  draw_cross(picture, at, 4.5, black, 2);
}

void draw_fine(cv::Mat& picture, const Eigen::Vector2d& at, PointUse use) {
  draw_plus(picture, at, 4.5, black, 3);
  draw_plus(picture, at, 4.0, use == PointUse::outline ? yellow : white, 1);
}

/// Whether the set is of the sub-pixel pose.
bool fine_use(const PointSet& set) {
  return set.level == 0 && (set.use == PointUse::refine || set.use == PointUse::outline);
}

Colour colour_of_level(int level) {
  static const Colour colours[] = {{80, 255, 80}, {255, 200, 60}, {60, 160, 255}, {255, 90, 255}, {90, 255, 255}};
  return colours[static_cast<std::size_t>(level) % std::size(colours)];
}

/// A square as wide as a pixel of the level, within reason.
void draw_follow(cv::Mat& picture, const Eigen::Vector2d& at, int level) {
  const double half = 2.0 + 1.5 * level;
  const std::vector<Eigen::Vector2d> corners{at + Eigen::Vector2d(-half, -half), at + Eigen::Vector2d(half, -half),
                                             at + Eigen::Vector2d(half, half), at + Eigen::Vector2d(-half, half)};
  draw_outline(picture, corners, black, 3);
  draw_outline(picture, corners, colour_of_level(level), 1);
}

void draw_verify(cv::Mat& picture, const Eigen::Vector2d& at) {
  draw_plus(picture, at, 1.5, black, 3);
  draw_plus(picture, at, 1.0, red, 1);
}

/// The points that follow candidates down, by level, and those of the score.
void draw_other_points(cv::Mat& picture, const Pattern& pattern,
                       const std::function<Eigen::Vector2d(double, double)>& place) {
  for (const auto& set : pattern.sets) {
    if (set.use != PointUse::verify) continue;
    for (const auto& point : set.points) draw_verify(picture, place(point.x, point.y));
  }
  for (const auto& set : pattern.sets) {
    if (set.use != PointUse::follow) continue;
    for (const auto& point : set.points) draw_follow(picture, place(point.x, point.y), set.level);
  }
}

/// The pattern's grey values, what is not part of it darkened, in colour.
cv::Mat shaded_pattern(const PatternImage& image) {
  cv::Mat picture(image.height, image.width, CV_8UC3);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const auto i = static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x);
      const int grey = image.grey[i] >> 8;
      const std::uint8_t mask = i < image.mask.size() ? image.mask[i] : 255;
      const int part = mask == 255 ? 4 : mask == 128 ? 2 : 0;  // quarters of the brightness that are kept
      const int dark = grey * part / 4;
      // A blue tint tells darkened from dark.
      picture.at<cv::Vec3b>(y, x) = cv::Vec3b(static_cast<std::uint8_t>(std::min(255, dark + (4 - part) * 15)),
                                              static_cast<std::uint8_t>(dark), static_cast<std::uint8_t>(dark));
    }
  }
  return picture;
}

}  // namespace

cv::Mat model_picture(const Pattern& pattern, int* zoom_used) {
  constexpr int wanted_side = 900;
  constexpr int narrowest = 640;  // the legend needs this
  constexpr double text_height = 11.0;
  constexpr double line_height = 26.0;
  const PatternImage& image = pattern.image;
  const int zoom = std::clamp(wanted_side / std::max({image.width, image.height, 1}), 1, 16);
  if (zoom_used != nullptr) *zoom_used = zoom;

  std::size_t coarse = 0;
  std::size_t fine = 0;
  std::size_t outline = 0;
  std::size_t verify = 0;
  std::vector<const PointSet*> follow;
  int coarse_level = 0;
  for (const auto& set : pattern.sets) {
    if (set.use == PointUse::search) {
      coarse += set.points.size();
      coarse_level = set.level;
    }
    if (fine_use(set)) (set.use == PointUse::outline ? outline : fine) += set.points.size();
    if (set.use == PointUse::verify) verify += set.points.size();
    if (set.use == PointUse::follow) follow.push_back(&set);
  }

  cv::Mat enlarged;
  cv::resize(shaded_pattern(image), enlarged, {}, zoom, zoom, cv::INTER_NEAREST);
  const cv::Mat bare = enlarged.clone();
  const int legend_lines = 6 + static_cast<int>(follow.size());
  constexpr int gap = 8;
  cv::Mat picture(enlarged.rows + static_cast<int>(line_height * (legend_lines + 0.5)),
                  std::max(narrowest, 2 * enlarged.cols + gap), CV_8UC3, Colour(64, 64, 64));
  enlarged.copyTo(picture(cv::Rect(0, 0, enlarged.cols, enlarged.rows)));

  const auto in_picture = [&](double x, double y) {
    const double half = 0.5;
    return Eigen::Vector2d((image.origin_x + x + half) * zoom - half, (image.origin_y + y + half) * zoom - half);
  };
  draw_outline(picture,
               {in_picture(pattern.left, pattern.top), in_picture(pattern.left + pattern.width, pattern.top),
                in_picture(pattern.left + pattern.width, pattern.top + pattern.height),
                in_picture(pattern.left, pattern.top + pattern.height)},
               Colour(80, 255, 80));
  for (const auto& set : pattern.sets) {
    if (!fine_use(set)) continue;
    for (const auto& point : set.points) draw_fine(picture, in_picture(point.x, point.y), set.use);
  }
  for (const auto& set : pattern.sets) {
    if (set.use != PointUse::search) continue;
    for (const auto& point : set.points) draw_coarse(picture, in_picture(point.x, point.y));
  }
  cv::Mat second = picture(cv::Rect(enlarged.cols + gap, 0, enlarged.cols, enlarged.rows));
  bare.copyTo(second);
  draw_other_points(second, pattern, in_picture);
  const double axis = 30.0;
  const Eigen::Vector2d origin = in_picture(0.0, 0.0);
  draw_arrow(picture, origin, origin + Eigen::Vector2d(axis, 0.0), red, 8.0);
  draw_arrow(picture, origin, origin + Eigen::Vector2d(0.0, axis), blue, 8.0);

  constexpr double symbol_x = 16.0;
  constexpr double text_x = 34.0;
  double y = enlarged.rows + line_height;
  const auto legend = [&](const std::string& text) {
    draw_text(picture, {text_x, y}, text, text_height, white);
    y += line_height;
  };
  const double middle = text_height / 2.0;
  draw_coarse(picture, {symbol_x, y - middle});
  legend(fmt::format("{} points of the coarse search, level {} (1/{} of the resolution)", coarse, coarse_level,
                     1 << coarse_level));
  draw_fine(picture, {symbol_x, y - middle}, PointUse::refine);
  legend(fmt::format("{} points of the sub-pixel pose, full resolution", fine));
  draw_fine(picture, {symbol_x, y - middle}, PointUse::outline);
  legend(fmt::format("{} more of them on the outermost edges", outline));
  for (const PointSet* set : follow) {
    draw_follow(picture, {symbol_x, y - middle}, set->level);
    legend(
        fmt::format("{} points that follow candidates down, level {} (right picture)", set->points.size(), set->level));
  }
  draw_verify(picture, {symbol_x, y - middle});
  legend(fmt::format("{} points of the score (right picture)", verify));
  draw_arrow(picture, {symbol_x - 8.0, y - middle - 4.0}, {symbol_x + 8.0, y - middle - 4.0}, red, 6.0);
  draw_arrow(picture, {symbol_x - 8.0, y - middle - 4.0}, {symbol_x - 8.0, y - middle + 12.0}, blue, 6.0);
  legend("origin with x (red) and y (blue); green: the trained rectangle");
  draw_text(picture, {text_x, y},
            fmt::format("{}: {:g} x {:g} pixels, {}x enlarged; blue tint: not part of the pattern", pattern.name,
                        pattern.width, pattern.height, zoom),
            text_height, white);
  return picture;
}

void write_model_picture(const Pattern& pattern, const std::string& path) {
  if (pattern.image.width <= 0 || pattern.image.height <= 0 ||
      pattern.image.grey.size() <
          static_cast<std::size_t>(pattern.image.width) * static_cast<std::size_t>(pattern.image.height)) {
    throw UsageError("the model of '" + pattern.name + "' holds no picture to draw");
  }
  write_png(path, model_picture(pattern));
}

}  // namespace vsfind
