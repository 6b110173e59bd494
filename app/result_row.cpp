#include "app/result_row.h"

#include <fmt/format.h>

#include <cmath>

namespace vsfind {

std::string fixed(double value, int digits) {
  if (!std::isfinite(value)) return {};
  std::string text = fmt::format("{:.{}f}", value, digits);
  if (text[0] == '-' && text.find_first_not_of("-0.") == std::string::npos) text.erase(0, 1);
  return text;
}

std::vector<RowCell> row_cells(const ResultRow& row) {
  std::vector<RowCell> cells;
  constexpr std::size_t columns = 24;
  cells.reserve(columns);
  const bool found = row.status == RowStatus::found;
  const Match& match = row.match;
  const auto text = [&](const char* column, std::string value) {
    cells.push_back({column, RowCell::Kind::text, std::move(value)});
  };
  const auto number = [&](const char* column, std::string value) {
    cells.push_back({column, RowCell::Kind::number, std::move(value)});
  };
  const auto of_pose = [&](const char* column, double value, int digits) {
    number(column, found ? fixed(value, digits) : std::string{});
  };
  text("source", row.source);
  number("frame", fmt::format("{}", row.frame));
  number("timestamp_ns", fmt::format("{}", row.timestamp_ns));
  text("field", name(row.field));
  text("model", row.model);
  text("status", name(row.status));
  number("instance", found ? fmt::format("{}", row.instance) : std::string{});
  of_pose("score", match.score, 5);
  of_pose("x", match.pose.x, 6);
  of_pose("y", match.pose.y, 6);
  of_pose("angle_deg", match.pose.angle_deg, 6);
  of_pose("scale_x", match.pose.scale_x, 7);
  of_pose("scale_y", match.pose.scale_y, 7);
  text("unit", found ? row.unit : std::string{});
  of_pose("image_x", match.frame_position.x(), 5);
  of_pose("image_y", match.frame_position.y(), 5);
  of_pose("sigma_x", match.sigma_x, 6);
  of_pose("sigma_y", match.sigma_y, 6);
  of_pose("sigma_angle_deg", match.sigma_angle_deg, 6);
  of_pose("visible", match.visible, 4);
  text("polarity", found ? name(match.polarity) : "");
  number("search_ms", row.search_ms ? fixed(*row.search_ms, 3) : std::string{});
  number("latency_ms", fixed(row.latency_ms, 3));
  cells.push_back({"timed_out", RowCell::Kind::flag, row.timed_out ? "1" : "0"});
  return cells;
}

}  // namespace vsfind
