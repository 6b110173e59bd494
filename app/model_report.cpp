#include "app/model_report.h"

#include <fmt/format.h>

namespace vsfind {
namespace {

std::string range_text(const Range& range, const char* unit) {
  if (!range.searched()) return fmt::format("{:g}{}", range.min, unit);
  return fmt::format("{:g} … {:g}{}", range.min, range.max, unit);
}

std::string scale_text(const Pattern& pattern) {
  if (pattern.common_scale) return range_text(pattern.scale_x, "") + ", both axes alike";
  return fmt::format("x {}, y {}", range_text(pattern.scale_x, ""), range_text(pattern.scale_y, ""));
}

const char* purpose(PointUse use) {
  switch (use) {
    case PointUse::search:
      return "exhaustive search";
    case PointUse::follow:
      return "following candidates down";
    case PointUse::refine:
      return "sub-pixel pose";
    case PointUse::outline:
      return "sub-pixel pose, outermost edges";
    case PointUse::verify:
      return "score";
  }
  return "";
}

}  // namespace

std::string describe(const Pattern& pattern) {
  std::string text;
  const auto line = [&text](const char* label, const std::string& value) {
    text += fmt::format("{:<12} {}\n", label, value);
  };
  const TrainReport& report = pattern.report;
  line("pattern", pattern.name);
  line("size", fmt::format("{:g} x {:g} pattern pixels, left {:g} and top {:g} from the origin", pattern.width,
                           pattern.height, pattern.left, pattern.top));
  line("unit", fmt::format("{}, {:g} {} per pattern pixel", pattern.unit, pattern.pitch, pattern.unit));
  line("aspect", fmt::format("{:g} (pixel width to height when trained)", pattern.pixel_aspect));
  line("angle", range_text(pattern.angle_deg, " degrees"));
  line("scale", scale_text(pattern));
  line("matching", fmt::format("{}, polarity {}, accuracy {}{}",
                               pattern.edges ? fmt::format("edges (threshold {:g})", pattern.edge_threshold) : "grey",
                               name(pattern.polarity), pattern.accuracy, pattern.spread ? ", points spread" : ""));
  std::string grid = fmt::format("from level {} (1/{} of the resolution)", pattern.top_level, 1 << pattern.top_level);
  if (pattern.angle_step_deg > 0.0) grid += fmt::format(", {:.3g} degrees a step", pattern.angle_step_deg);
  if (pattern.scale_step > 0.0) grid += fmt::format(", {:.3g}% of scale a step", 100.0 * pattern.scale_step);
  line("search", grid);
  for (const auto& set : pattern.sets) {
    line("points", fmt::format("level {}: {:5} for {}", set.level, set.points.size(), purpose(set.use)));
  }
  line("expected", fmt::format("S.D. x {:.5f} {}, y {:.5f} {}, angle {:.5f} degrees at a noise of 2 grey levels",
                               report.sigma_x, pattern.unit, report.sigma_y, pattern.unit, report.sigma_angle_deg));
  line("impostor", fmt::format("best score of anything else when trained: {:.3f}{}{}", report.impostor_score,
                               report.impostor.empty() ? "" : ", ", report.impostor));
  line("noise", fmt::format("{:.2f} grey levels in the training image", report.noise_sigma));
  line("trained in", fmt::format("{:.1f} ms", report.training_ms));
  return text;
}

std::string points_csv(const Pattern& pattern) {
  std::string text = "level,x,y,use,value,gradient_x,gradient_y\n";
  for (const auto& set : pattern.sets) {
    for (const auto& p : set.points) {
      text += fmt::format("{},{:.4f},{:.4f},{},{:.3f},{:.4f},{:.4f}\n", set.level, p.x, p.y, name(set.use), p.value,
                          p.gradient_x, p.gradient_y);
    }
  }
  return text;
}

}  // namespace vsfind
