#include "measured.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

namespace vsfind::measure {

double Errors::mean() const {
  return values.empty() ? 0.0 : std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double Errors::sd() const {
  if (values.size() < 2) return 0.0;
  const double centre = mean();
  double sum = 0.0;
  for (const double v : values) sum += (v - centre) * (v - centre);
  return std::sqrt(sum / static_cast<double>(values.size() - 1));
}

double Errors::rms() const {
  if (values.empty()) return 0.0;
  double sum = 0.0;
  for (const double v : values) sum += v * v;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

double Errors::max() const {
  double most = 0.0;
  for (const double v : values) most = std::max(most, std::abs(v));
  return most;
}

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void print_header() {
  fmt::print("{:<34}{:>6}{:>8}{:>8}  {:<26}{:<26}{:<26}{:<22}{:>9}  {}\n", "row", "n", "found%", "right%",
             "x sd/rms/max px", "y sd/rms/max px", "angle sd/rms/max deg", "scale x,y max", "ms", "target");
}

void print(const Row& row) {
  const auto three = [](const Errors& e) { return fmt::format("{:.5f} {:.5f} {:.4f}", e.sd(), e.rms(), e.max()); };
  const double found = row.expected > 0 ? 100.0 * row.found / row.expected : 0.0;
  fmt::print("{:<34}{:>6}{:>8.1f}{:>8.1f}  {:<26}{:<26}{:<26}{:<22}{:>9.3f}  {:<4} {}{}{}\n", row.name, row.scenes,
             found, row.right_percent(), three(row.x), three(row.y), three(row.angle),
             fmt::format("{:.5f} {:.5f}", row.scale_x.max(), row.scale_y.max()), median(row.ms), row.ok ? "ok" : "FAIL",
             row.target, row.extra.empty() ? "" : " | ", row.extra);
  std::fflush(stdout);
}

}  // namespace vsfind::measure
