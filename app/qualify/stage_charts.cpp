#include "app/qualify/stage_charts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/drawing.h"
#include "app/overlay.h"

namespace vsfind {
namespace {

class ChartMaker {
 public:
  ChartMaker(const StageRun& run, StageKind kind) : prefix_(name(kind)) {
    for (const StageFrame& frame : run.frames) x_.push_back(frame.step + 1.0);
  }

  NamedChart& add(const std::string& file, const std::string& title, const std::string& unit,
                  const std::string& caption) {
    colours_ = 0;
    NamedChart& made = charts_.emplace_back();
    made.file = prefix_ + "-" + file + ".png";
    made.caption = caption;
    made.chart.title = title;
    made.chart.x_label = "sample image";
    made.chart.y_label = unit;
    made.chart.symmetric = true;
    made.chart.whole_steps = true;
    return made;
  }

  void curve(NamedChart& to, const std::string& name, const Deviations& deviations, int digits) {
    if (deviations.spread.count == 0) return;
    const std::string label = fmt::format("{}S.D. {:.{}f}, max {:.{}f}", name.empty() ? "" : name + ": ",
                                          deviations.spread.sd, digits, deviations.spread.max, digits);
    to.chart.curves.push_back({label, x_, deviations.values, chart_colour(colours_++), true, true});
  }

  /// The bound as two level lines.
  void bound(NamedChart& to, double sigma, int digits) {
    if (!(sigma > 0.0) || x_.size() < 2) return;
    for (const double sign : {1.0, -1.0}) {
      to.chart.curves.push_back({sign > 0.0 ? fmt::format("bound {:.{}f} (1 sigma)", sigma, digits) : "",
                                 {x_.front(), x_.back()},
                                 {sign * sigma, sign * sigma},
                                 chart_colour(4),
                                 true,
                                 false});
    }
  }

  std::vector<NamedChart> take() { return std::move(charts_); }

 private:
  std::string prefix_;
  std::vector<double> x_;
  std::vector<NamedChart> charts_;
  std::size_t colours_ = 0;
};

constexpr double degree = std::numbers::pi / 180.0;

/// Digits that show two places of a value.
int digits_for(double value) {
  return value > 0.0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(value))), 1, 7) : 4;
}

}  // namespace

std::vector<NamedChart> stage_charts(const StageRun& run, const StageAnalysis& a) {
  ChartMaker maker(run, a.kind);
  const std::string unit = run.unit == "px" ? "pixels" : run.unit;
  const double across =
      std::hypot(run.bound.x * std::sin(a.direction_deg * degree), run.bound.y * std::cos(a.direction_deg * degree));
  const int digits = digits_for(std::max(run.bound.x, 1e-6));
  const int angle_digits = digits_for(std::max(run.bound.angle_deg, 1e-6));
  if (a.kind == StageKind::linear) {
    auto& pattern = maker.add("pattern", "Pattern: nonlinearity of the travel", unit,
                              "Deviation of the found locations from the straight line fitted to the travel, and along "
                              "it from equal steps.");
    maker.curve(pattern, "across", a.pattern_across, digits);
    maker.curve(pattern, "along", a.pattern_along, digits);
    maker.bound(pattern, across, digits);
    if (a.with_fiducials > 0) {
      auto& fiducials = maker.add("fiducials", "Fiducials: nonlinearity of the travel", unit,
                                  "The same for the centre of the fiducial squares, measured by line fitting.");
      maker.curve(fiducials, "across", a.fiducials_across, digits);
      maker.curve(fiducials, "along", a.fiducials_along, digits);
      maker.bound(fiducials, a.fiducial_sigma, digits);
    }
  } else {
    auto& pattern = maker.add("pattern", "Pattern: nonlinearity of the rotation", "degrees",
                              "Deviation of the found angles from equal steps.");
    maker.curve(pattern, "", a.pattern_turn, angle_digits);
    maker.bound(pattern, run.bound.angle_deg, angle_digits);
    if (a.with_fiducials > 0) {
      auto& fiducials = maker.add("fiducials", "Fiducials: nonlinearity of the rotation", "degrees",
                                  "The same for the angle of the fiducial squares.");
      maker.curve(fiducials, "", a.fiducials_turn, angle_digits);
      maker.bound(fiducials, a.fiducial_sigma_angle_deg, angle_digits);
    }
  }
  if (a.with_fiducials == 0) return maker.take();
  auto& relative =
      maker.add("relative", "Pattern relative to the fiducials: position", unit,
                run.angle_searched ? "Error in translation relative to the fiducials while also solving for rotation."
                                   : "Error in translation relative to the fiducials: what stage and camera do is "
                                     "taken off.");
  maker.curve(relative, "x", a.relative_x, digits);
  maker.curve(relative, "y", a.relative_y, digits);
  maker.bound(relative, std::hypot(std::hypot(run.bound.x, run.bound.y) / std::sqrt(2.0), a.fiducial_sigma), digits);
  if (run.angle_searched) {
    auto& angle = maker.add("relative-angle", "Pattern relative to the fiducials: angle", "degrees",
                            "Error in rotation relative to the fiducials.");
    maker.curve(angle, "", a.relative_angle, angle_digits);
    maker.bound(angle, std::hypot(run.bound.angle_deg, a.fiducial_sigma_angle_deg), angle_digits);
  }
  return maker.take();
}

cv::Mat stage_picture(const StageRun& run, const SourceMapping& mapping) {
  cv::Mat canvas = overlay_canvas(run.picture, run.field);
  PictureResult shown;
  shown.field = run.field;
  shown.patterns.emplace_back();
  if (run.picture_match) shown.patterns.back().matches.push_back(*run.picture_match);
  draw_matches(canvas, shown, {run.pattern}, mapping.mapping);
  const Mapping of_picture = mapping.mapping.for_field(run.field);
  for (std::size_t i = 0; i < run.squares.size(); ++i) {
    std::vector<Eigen::Vector2d> outline;
    for (const auto& corner : run.squares[i].corners) outline.push_back(of_picture.frame_from_image(corner));
    draw_outline(canvas, outline, Colour(0, 200, 255), 2);
    draw_text(canvas, of_picture.frame_from_image(run.squares[i].centre) + Eigen::Vector2d(-8.0, 5.0),
              fmt::format("{}", i + 1), 11.0, Colour(0, 200, 255));
  }
  return canvas;
}

}  // namespace vsfind
