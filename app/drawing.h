#pragma once
/// @file
/// Sub-pixel drawing into a colour picture; coordinates are pixels with integers at pixel centres.

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace vsfind {

using Colour = cv::Scalar;  ///< blue, green, red

void draw_line(cv::Mat& picture, const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Colour& colour,
               int thickness = 1);
/// A closed line through the points.
void draw_outline(cv::Mat& picture, const std::vector<Eigen::Vector2d>& points, const Colour& colour,
                  int thickness = 1);
/// A line with a head at `to`.
void draw_arrow(cv::Mat& picture, const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Colour& colour,
                double head);
/// A `+` whose arms reach `arm` pixels from the centre.
void draw_plus(cv::Mat& picture, const Eigen::Vector2d& centre, double arm, const Colour& colour, int thickness = 1);
/// An `x` likewise.
void draw_cross(cv::Mat& picture, const Eigen::Vector2d& centre, double arm, const Colour& colour, int thickness = 1);
/// One line of text with a dark rim, its lower left corner at `at`; `height` is that of a capital letter.
void draw_text(cv::Mat& picture, const Eigen::Vector2d& at, const std::string& text, double height,
               const Colour& colour);
/// How wide that text is.
[[nodiscard]] double text_width(const std::string& text, double height);

/// Writes a PNG, the whole file or an exception. Throws IoError.
void write_png(const std::string& path, const cv::Mat& picture);

}  // namespace vsfind
