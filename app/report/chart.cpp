#include "app/report/chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "app/report/spread.h"

namespace vsfind {
namespace {

const cv::Scalar ink(51, 39, 29);
const cv::Scalar faint(237, 232, 227);
const cv::Scalar axis_colour(160, 148, 138);
constexpr int font = cv::FONT_HERSHEY_SIMPLEX;
constexpr double text_scale = 0.72;
constexpr int least_left = 128;
constexpr int label_gap = 12;     // between an ordinate's number and the axis
constexpr int upright_room = 48;  // of the ordinate's name
constexpr int right = 24;
constexpr int title_y = 38;
constexpr int legend_y = 68;
constexpr int legend_row = 26;
constexpr int below_legend = 24;
constexpr int bottom = 96;
constexpr int shift = 4;

int width_of(const std::string& text, double scale) {
  int baseline = 0;
  return cv::getTextSize(text, font, scale, 1, &baseline).width;
}

void write(cv::Mat& picture, const std::string& text, int x, int y, double scale, const cv::Scalar& colour,
           int thickness = 1) {
  cv::putText(picture, text, {x, y}, font, scale, colour, thickness, cv::LINE_AA);
}

/// What is shown along one axis, and where.
struct Axis {
  double min = 0.0;
  double max = 1.0;
  double step = 0.2;
  int begin = 0;  ///< pixel of min
  int end = 0;    ///< pixel of max

  [[nodiscard]] double pixel(double value) const { return begin + (value - min) / (max - min) * (end - begin); }
  [[nodiscard]] std::string label(double value) const {
    const int digits = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 9);
    if (std::abs(value) < step * 1e-6) value = 0.0;
    return fmt::format("{:.{}f}", value, digits);
  }
  [[nodiscard]] std::vector<double> ticks() const {
    std::vector<double> values;
    const double first = std::ceil(min / step - 1e-6);
    for (double i = first; i * step <= max + 1e-6 * step && values.size() < 40; i += 1.0) values.push_back(i * step);
    return values;
  }
};

void widen(Axis& axis, double part) {
  if (axis.max - axis.min < 1e-12 * std::max(1.0, std::abs(axis.max))) {
    const double reach = std::max(1e-6, std::abs(axis.max) * 0.05);
    axis.min -= reach;
    axis.max += reach;
  }
  const double more = (axis.max - axis.min) * part;
  axis.min -= more;
  axis.max += more;
}

cv::Point fixed_point(double x, double y) {
  constexpr double one = 1 << shift;
  return {static_cast<int>(std::lround(x * one)), static_cast<int>(std::lround(y * one))};
}

void draw_bars(cv::Mat& picture, const Curve& curve, const Axis& x_axis, const Axis& y_axis) {
  const double wide = curve.x.size() > 1 ? curve.x[1] - curve.x[0] : x_axis.max - x_axis.min;
  for (std::size_t i = 0; i < curve.x.size(); ++i) {
    if (!(curve.y[i] > 0.0)) continue;
    const cv::Point a(static_cast<int>(std::lround(x_axis.pixel(curve.x[i] - wide / 2.0))) + 1,
                      static_cast<int>(std::lround(y_axis.pixel(curve.y[i]))));
    const cv::Point b(static_cast<int>(std::lround(x_axis.pixel(curve.x[i] + wide / 2.0))) - 1, y_axis.begin);
    cv::rectangle(picture, a, {std::max(a.x, b.x), b.y}, curve.colour, cv::FILLED);
  }
}

void draw_curve(cv::Mat& picture, const Curve& curve, const Axis& x_axis, const Axis& y_axis) {
  cv::Point last;
  bool has_last = false;
  for (std::size_t i = 0; i < curve.x.size(); ++i) {
    if (!std::isfinite(curve.y[i]) || !std::isfinite(curve.x[i])) {
      has_last = false;
      continue;
    }
    const cv::Point here = fixed_point(x_axis.pixel(curve.x[i]), y_axis.pixel(curve.y[i]));
    if (curve.joined && has_last) cv::line(picture, last, here, curve.colour, 2, cv::LINE_AA, shift);
    if (curve.markers) cv::circle(picture, here, 5 << shift, curve.colour, cv::FILLED, cv::LINE_AA, shift);
    last = here;
    has_last = true;
  }
}

constexpr double legend_scale = 0.6;
constexpr int legend_swatch = 38;
constexpr int legend_gap = 28;

/// Where each curve's entry stands: in as many rows as it takes.
std::vector<cv::Point> legend_places(const Chart& chart, int left) {
  std::vector<cv::Point> places;
  cv::Point at(left, legend_y);
  for (const auto& curve : chart.curves) {
    const int width = curve.name.empty() ? 0 : legend_swatch + width_of(curve.name, legend_scale);
    if (at.x > left && at.x + width > chart_width - right) at = {left, at.y + legend_row};
    places.push_back(at);
    if (width > 0) at.x += width + legend_gap;
  }
  return places;
}

void draw_legend(cv::Mat& picture, const Chart& chart, const std::vector<cv::Point>& places) {
  for (std::size_t i = 0; i < chart.curves.size(); ++i) {
    const Curve& curve = chart.curves[i];
    if (curve.name.empty()) continue;
    const auto [x, y] = places[i];
    cv::line(picture, {x, y - 6}, {x + 30, y - 6}, curve.colour, curve.joined ? 3 : 1, cv::LINE_AA);
    if (curve.markers) cv::circle(picture, {x + 15, y - 6}, 5, curve.colour, cv::FILLED, cv::LINE_AA);
    write(picture, curve.name, x + legend_swatch, y, legend_scale, ink);
  }
}

void draw_axes(cv::Mat& picture, const Chart& chart, const Axis& x_axis, const Axis& y_axis) {
  for (const double value : y_axis.ticks()) {
    const int y = static_cast<int>(std::lround(y_axis.pixel(value)));
    const bool zero = std::abs(value) < y_axis.step * 1e-6;
    cv::line(picture, {x_axis.begin, y}, {x_axis.end, y}, zero ? axis_colour : faint, zero ? 2 : 1);
    const std::string label = y_axis.label(value);
    write(picture, label, x_axis.begin - label_gap - width_of(label, text_scale), y + 8, text_scale, ink);
  }
  for (const double value : x_axis.ticks()) {
    const int x = static_cast<int>(std::lround(x_axis.pixel(value)));
    cv::line(picture, {x, y_axis.begin}, {x, y_axis.begin + 8}, axis_colour, 2);
    const std::string label = x_axis.label(value);
    write(picture, label, x - width_of(label, text_scale) / 2, y_axis.begin + 34, text_scale, ink);
  }
  cv::rectangle(picture, cv::Point(x_axis.begin, y_axis.end), cv::Point(x_axis.end, y_axis.begin), axis_colour, 2);
  write(picture, chart.x_label, (x_axis.begin + x_axis.end - width_of(chart.x_label, text_scale)) / 2,
        chart_height - 22, text_scale, ink);
  // The ordinate's label stands upright: written flat, then turned.
  cv::Mat flat(40, y_axis.begin - y_axis.end + 60, CV_8UC3, cv::Scalar::all(255));
  write(flat, chart.y_label, std::max(0, (flat.cols - width_of(chart.y_label, text_scale)) / 2), 28, text_scale, ink);
  cv::Mat upright;
  cv::rotate(flat, upright, cv::ROTATE_90_COUNTERCLOCKWISE);
  const int place = std::max(0, (y_axis.begin + y_axis.end) / 2 - upright.rows / 2);
  upright.copyTo(picture(cv::Rect(2, place, upright.cols, upright.rows)));
}

}  // namespace

cv::Scalar chart_colour(std::size_t index) {
  static const std::array<cv::Scalar, 5> colours{cv::Scalar(178, 114, 0), cv::Scalar(0, 94, 213),
                                                 cv::Scalar(115, 158, 0), cv::Scalar(167, 121, 204),
                                                 cv::Scalar(120, 120, 120)};
  return colours[index % colours.size()];
}

double tick_step(double range, int most) {
  if (!(range > 0.0) || !std::isfinite(range)) return 1.0;
  const double rough = range / most;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= rough * (1.0 - 1e-9)) return factor * power;
  }
  return 10.0 * power;
}

cv::Mat draw_chart(const Chart& chart) {
  cv::Mat picture(chart_height, chart_width, CV_8UC3, cv::Scalar::all(255));
  constexpr double most = std::numeric_limits<double>::max();
  Axis x_axis{most, -most, 1.0, least_left, chart_width - right};
  Axis y_axis{most, -most, 1.0, chart_height - bottom, legend_y + below_legend};
  for (const auto& curve : chart.curves) {
    for (std::size_t i = 0; i < curve.x.size(); ++i) {
      if (!std::isfinite(curve.x[i]) || !std::isfinite(curve.y[i])) continue;
      x_axis.min = std::min(x_axis.min, curve.x[i]);
      x_axis.max = std::max(x_axis.max, curve.x[i]);
      y_axis.min = std::min(y_axis.min, curve.y[i]);
      y_axis.max = std::max(y_axis.max, curve.y[i]);
    }
  }
  if (x_axis.max < x_axis.min) {
    write(picture, chart.title, least_left, title_y, 0.86, ink, 2);
    const std::string text = "nothing was measured";
    write(picture, text, (chart_width - width_of(text, text_scale)) / 2, chart_height / 2, text_scale, axis_colour);
    return picture;
  }
  if (chart.symmetric) {
    y_axis.max = std::max({std::abs(y_axis.min), std::abs(y_axis.max), 1e-12});
    y_axis.min = -y_axis.max;
  }
  widen(x_axis, chart.bars ? 0.06 : 0.03);
  widen(y_axis, 0.08);
  if (chart.from_zero || chart.bars) y_axis.min = 0.0;
  x_axis.step = tick_step(x_axis.max - x_axis.min, 10);
  if (chart.whole_steps) x_axis.step = std::max(1.0, x_axis.step);
  y_axis.step = tick_step(y_axis.max - y_axis.min, 8);
  for (const double value : y_axis.ticks())
    x_axis.begin = std::max(x_axis.begin, width_of(y_axis.label(value), text_scale) + label_gap + upright_room);
  const std::vector<cv::Point> places = legend_places(chart, x_axis.begin);
  if (!places.empty()) y_axis.end = places.back().y + below_legend;
  write(picture, chart.title, x_axis.begin, title_y, 0.86, ink, 2);
  draw_axes(picture, chart, x_axis, y_axis);
  for (const auto& curve : chart.curves) {
    if (chart.bars) {
      draw_bars(picture, curve, x_axis, y_axis);
    } else {
      draw_curve(picture, curve, x_axis, y_axis);
    }
  }
  draw_legend(picture, chart, places);
  return picture;
}

Chart histogram_of(const std::vector<double>& values, int classes, double reach) {
  Chart chart;
  chart.bars = true;
  chart.y_label = "count";
  Curve bars;
  bars.colour = chart_colour(0);
  std::vector<double> finite = values;
  std::erase_if(finite, [](double v) { return !std::isfinite(v); });
  if (!finite.empty()) {
    const double low = quantile_of(finite, 0.0);
    const double high = quantile_of(finite, reach);
    const double wide = high > low ? (high - low) / classes : 1.0;
    const int count = high > low ? classes : 1;
    for (int i = 0; i < count; ++i) {
      bars.x.push_back(low + (i + 0.5) * wide);
      bars.y.push_back(0.0);
    }
    for (const double v : finite) {
      const auto place = static_cast<int>(std::clamp((v - low) / wide, 0.0, count - 1.0));
      bars.y[static_cast<std::size_t>(place)] += 1.0;
    }
  }
  chart.curves.push_back(std::move(bars));
  return chart;
}

}  // namespace vsfind
