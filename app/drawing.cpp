#include "app/drawing.h"

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string_view>

#include "acquisition/errors.h"
#include "app/output_file.h"

namespace vsfind {
namespace {

constexpr int shift = 8;         // 1/256 px
constexpr double far = 30000.0;  // OpenCV's fixed point holds this at that shift

bool drawable(const Eigen::Vector2d& p) { return std::abs(p.x()) < far && std::abs(p.y()) < far; }

cv::Point fixed_point(const Eigen::Vector2d& p) {
  constexpr double one = 1 << shift;
  return {static_cast<int>(std::lround(p.x() * one)), static_cast<int>(std::lround(p.y() * one))};
}

constexpr int font = cv::FONT_HERSHEY_SIMPLEX;
constexpr double font_capital = 21.0;  // pixels of a capital letter at scale 1

}  // namespace

void draw_line(cv::Mat& picture, const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Colour& colour,
               int thickness) {
  if (!drawable(from) || !drawable(to)) return;
  cv::line(picture, fixed_point(from), fixed_point(to), colour, thickness, cv::LINE_AA, shift);
}

void draw_outline(cv::Mat& picture, const std::vector<Eigen::Vector2d>& points, const Colour& colour, int thickness) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    draw_line(picture, points[i], points[(i + 1) % points.size()], colour, thickness);
  }
}

void draw_arrow(cv::Mat& picture, const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Colour& colour,
                double head) {
  draw_line(picture, from, to, colour);
  if ((to - from).norm() < 1e-6) return;
  const Eigen::Vector2d along = (to - from).normalized() * head;
  const Eigen::Vector2d across(-along.y(), along.x());
  draw_line(picture, to, to - along + 0.5 * across, colour);
  draw_line(picture, to, to - along - 0.5 * across, colour);
}

void draw_plus(cv::Mat& picture, const Eigen::Vector2d& centre, double arm, const Colour& colour, int thickness) {
  const Eigen::Vector2d x(arm, 0.0);
  const Eigen::Vector2d y(0.0, arm);
  draw_line(picture, centre - x, centre + x, colour, thickness);
  draw_line(picture, centre - y, centre + y, colour, thickness);
}

void draw_cross(cv::Mat& picture, const Eigen::Vector2d& centre, double arm, const Colour& colour, int thickness) {
  const Eigen::Vector2d a(arm, arm);
  const Eigen::Vector2d b(arm, -arm);
  draw_line(picture, centre - a, centre + a, colour, thickness);
  draw_line(picture, centre - b, centre + b, colour, thickness);
}

void draw_text(cv::Mat& picture, const Eigen::Vector2d& at, const std::string& text, double height,
               const Colour& colour) {
  if (!drawable(at)) return;
  const cv::Point corner(static_cast<int>(std::lround(at.x())), static_cast<int>(std::lround(at.y())));
  const double scale = height / font_capital;
  cv::putText(picture, text, corner, font, scale, Colour(0, 0, 0), 3, cv::LINE_AA);
  cv::putText(picture, text, corner, font, scale, colour, 1, cv::LINE_AA);
}

double text_width(const std::string& text, double height) {
  int baseline = 0;
  return cv::getTextSize(text, font, height / font_capital, 1, &baseline).width;
}

void write_png(const std::string& path, const cv::Mat& picture) {
  std::vector<unsigned char> bytes;
  if (!cv::imencode(".png", picture, bytes, {cv::IMWRITE_PNG_COMPRESSION, 3})) {
    throw IoError(path + ": the picture cannot be encoded as PNG");
  }
  OutputFile(path).write(std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

}  // namespace vsfind
