#include "finder/telling_places.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace vsfind {

std::vector<char> telling_places(const std::vector<float>& values, const std::vector<float>& view) {
  const std::size_t n = values.size();
  std::vector<char> telling(n, 0);
  if (n == 0) return telling;
  double t = 0.0;
  double v = 0.0;
  for (std::size_t k = 0; k < n; ++k) {
    t += static_cast<double>(values[k]) / static_cast<double>(n);
    v += static_cast<double>(view[k]) / static_cast<double>(n);
  }
  double tt = 0.0;
  double tv = 0.0;
  for (std::size_t k = 0; k < n; ++k) {
    tt += (static_cast<double>(values[k]) - t) * (static_cast<double>(values[k]) - t);
    tv += (static_cast<double>(values[k]) - t) * (static_cast<double>(view[k]) - v);
  }
  const double gain = tv / std::max(1e-9, tt);
  std::vector<double> difference(n);
  for (std::size_t k = 0; k < n; ++k) {
    difference[k] = std::abs(static_cast<double>(view[k]) - v - gain * (static_cast<double>(values[k]) - t));
  }
  constexpr double clearly = 0.75;
  const double least = clearly * *std::max_element(difference.begin(), difference.end());
  for (std::size_t k = 0; k < n; ++k) telling[k] = difference[k] > least ? 1 : 0;
  return telling;
}

}  // namespace vsfind
