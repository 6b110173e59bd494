#pragma once
/// @file
/// What `find`, `replay` and `live` are asked to do: one struct behind the command line and the configuration.

#include <string>
#include <vector>

#include "app/settings.h"
#include "app/source_mapping.h"
#include "app/values.h"
#include "finder/search.h"

namespace vsfind {

struct RunOptions {
  std::vector<std::string> models;  ///< files
  SearchOptions search;
  FieldMode field = FieldMode::frame;
  MappingChoice mapping;
  std::string csv;      ///< file, "-" for stdout, "" for none
  std::string jsonl;    ///< the same
  std::string overlay;  ///< folder for pictures, "" for none
  std::string report;   ///< folder for a report, "" for none
};

/// The settings that fill `options`, which must outlive them. `field_help` says what --field means for the command.
[[nodiscard]] std::vector<Setting> run_settings(RunOptions& options, const std::string& field_help);

/// Checks what only all settings together can tell, and falls back to CSV on stdout. Throws UsageError.
void complete_run_options(RunOptions& options);

}  // namespace vsfind
