#pragma once
/// @file
/// Statistics of poses found against poses known, and the table in which they are shown.

#include <string>
#include <vector>

namespace vsfind::measure {

/// Errors of one parameter over many scenes.
struct Errors {
  std::vector<double> values;
  void add(double value) { values.push_back(value); }
  [[nodiscard]] double mean() const;
  [[nodiscard]] double sd() const;   ///< about the mean
  [[nodiscard]] double rms() const;  ///< about zero
  [[nodiscard]] double max() const;  ///< of the absolute values
};

[[nodiscard]] double median(std::vector<double> values);

/// What one row of the table was measured on.
struct Row {
  std::string name;
  int scenes = 0;
  int expected = 0;  ///< instances to be found
  int found = 0;
  int right = 0;
  Errors x, y, angle, scale_x, scale_y;  ///< of those found and right; px, degrees, ratio
  Errors ratio_x, ratio_y, ratio_angle;  ///< of the error to the standard deviation that the finder predicted
  std::vector<double> ms;                ///< a search each
  std::string extra;                     ///< what the columns cannot say
  std::string target;
  bool ok = true;
  [[nodiscard]] double right_percent() const { return expected > 0 ? 100.0 * right / expected : 0.0; }
};

void print_header();
void print(const Row& row);

}  // namespace vsfind::measure
