#pragma once
/// @file
/// The YAML configuration: keys are the settings' names with `_` for `-`, values as on the command line.

#include <optional>
#include <string>
#include <vector>

#include "app/settings.h"

namespace vsfind {

/// A key and its values as written: one for a scalar, any number for a list.
struct ConfigEntry {
  std::string key;
  int line = 0;  ///< from 1
  bool list = false;
  std::vector<std::string> values;
  bool pairs = false;                              ///< of a mapping, each value being NAME=VALUE
  std::vector<std::vector<ConfigEntry>> blocks{};  ///< of a list whose items are keys and values themselves
};

struct Config {
  std::string path;
  std::vector<ConfigEntry> entries;

  /// Takes the entry of that key out, if it is there.
  [[nodiscard]] std::optional<ConfigEntry> take(const std::string& key);
};

/// Reads a file of at most 1 MB. Throws IoError where it cannot be read, UsageError (file:line: …) where it is not a
/// mapping of keys to scalars, lists of scalars, mappings of scalars (taken for a list of KEY=VALUE) or lists of such
/// mappings, or a key stands twice.
[[nodiscard]] Config load_config(const std::string& path);

/// Sets every key. Paths are taken relative to the configuration's folder. Throws UsageError (file:line: key …) where
/// a key is unknown, naming the nearest known one, or its value cannot be taken.
void apply_config(const Config& config, const std::vector<Setting>& settings);

}  // namespace vsfind
