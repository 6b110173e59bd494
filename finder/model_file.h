#pragma once
/// @file
/// A pattern as a file: JSON with a format version and a checksum.

#include <string>

#include "finder/pattern.h"

namespace vsfind {

/// Writes the whole file or nothing. Throws IoError.
void save_model(const Pattern& pattern, const std::string& path);

/// Throws IoError where the file cannot be read, UsageError where it is no model, damaged, or of a newer version; the
/// line names file, key and allowed values.
[[nodiscard]] Pattern load_model(const std::string& path);

}  // namespace vsfind
