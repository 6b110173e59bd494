#pragma once
/// @file
/// The rows of the accuracy table, in groups.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace vsfind::measure {

struct Settings {
  int scenes = 200;        ///< of each row of random scenes
  std::uint64_t seed = 1;  ///< of the whole table
  double noise = 2.0;      ///< of the calibrated rows, in the training picture, too; grey levels
};

/// A row, or a few that belong together, that prints itself and says whether all targets were reached.
struct Entry {
  std::string name;  ///< what --rows is matched against
  std::function<bool(const Settings&)> measure;
};

[[nodiscard]] std::vector<Entry> accuracy_rows();    ///< translation, rotation, the accuracy table, scales, fields
[[nodiscard]] std::vector<Entry> robust_rows();      ///< random poses in clutter under every difficulty
[[nodiscard]] std::vector<Entry> trust_rows();       ///< false alarms, instances, honest sigmas, growth
[[nodiscard]] std::vector<Entry> calibrated_rows();  ///< poses on the plane through pixel shape, slant and lens

}  // namespace vsfind::measure
