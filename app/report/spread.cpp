#include "app/report/spread.h"

#include <algorithm>
#include <cmath>

namespace vsfind {

Spread spread_of(const std::vector<double>& values) {
  Spread spread;
  double sum = 0.0;
  double squares = 0.0;
  for (const double v : values) {
    if (!std::isfinite(v)) continue;
    ++spread.count;
    sum += v;
    squares += v * v;
    spread.max = std::max(spread.max, std::abs(v));
  }
  if (spread.count == 0) return spread;
  const auto n = static_cast<double>(spread.count);
  spread.mean = sum / n;
  spread.rms = std::sqrt(squares / n);
  double about = 0.0;
  for (const double v : values) about += std::isfinite(v) ? (v - spread.mean) * (v - spread.mean) : 0.0;
  spread.sd = spread.count > 1 ? std::sqrt(about / (n - 1.0)) : 0.0;
  return spread;
}

double quantile_of(std::vector<double> values, double q) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  if (values.empty()) return 0.0;
  const double place = std::clamp(q, 0.0, 1.0) * static_cast<double>(values.size());
  const auto index = static_cast<std::size_t>(std::max(0.0, std::ceil(place) - 1.0));
  const auto wanted = values.begin() + static_cast<std::ptrdiff_t>(std::min(index, values.size() - 1));
  std::nth_element(values.begin(), wanted, values.end());
  return *wanted;
}

}  // namespace vsfind
