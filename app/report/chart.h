#pragma once
/// @file
/// A chart with axes, drawn for a report: curves over an abscissa, or the bars of a histogram.

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace vsfind {

/// Colours of curves, told apart by people who do not see red and green apart, too.
[[nodiscard]] cv::Scalar chart_colour(std::size_t index);

struct Curve {
  std::string name;  ///< for the legend; "" for none
  std::vector<double> x;
  std::vector<double> y;  ///< as many; what is not finite is a gap
  cv::Scalar colour;
  bool joined = true;   ///< points joined by lines
  bool markers = true;  ///< each point marked
};

/// Text is ASCII; units belong into the labels.
struct Chart {
  std::string title;
  std::string x_label;
  std::string y_label;
  std::vector<Curve> curves;
  bool bars = false;         ///< curve 0 as bars of a histogram: x are their middles, evenly spaced
  bool from_zero = false;    ///< the ordinate begins at 0
  bool symmetric = false;    ///< the ordinate reaches as far below 0 as above
  bool whole_steps = false;  ///< ticks of the abscissa at whole numbers only
};

inline constexpr int chart_width = 1048;  ///< pixels; twice what a report shows, so that it is sharp on any screen
inline constexpr int chart_height = 620;

/// Colour picture of chart_width × chart_height. A chart without any finite point says so.
[[nodiscard]] cv::Mat draw_chart(const Chart& chart);

/// Bars of about the given number of classes between the smallest and the `reach` quantile of the values; what lies
/// above goes into the last one.
[[nodiscard]] Chart histogram_of(const std::vector<double>& values, int classes, double reach = 1.0);

/// A step of 1, 2 or 5 times a power of ten that divides `range` into at most `most` parts.
[[nodiscard]] double tick_step(double range, int most);

}  // namespace vsfind
