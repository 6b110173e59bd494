#pragma once
/// @file
/// What a list of errors comes to.

#include <cstddef>
#include <vector>

namespace vsfind {

/// Values that are not finite are passed over.
struct Spread {
  std::size_t count = 0;
  double mean = 0.0;
  double sd = 0.0;   ///< about the mean, of a sample (n − 1)
  double rms = 0.0;  ///< about zero
  double max = 0.0;  ///< the largest absolute value
};
[[nodiscard]] Spread spread_of(const std::vector<double>& values);

/// The value that the part `q` (0 … 1) of all finite ones does not exceed; 0 where there is none.
[[nodiscard]] double quantile_of(std::vector<double> values, double q);

}  // namespace vsfind
