#pragma once
/// @file
/// Pictures of searches that went wrong, for a person to look at.

#include <string>

#include "stage.h"

namespace vsfind::measure {

/// Writes the shot as `folder`/`name`.png (spaces and slashes of the name become underscores), the pattern's outline at
/// the true poses in green and at the poses found in red, with scores. Throws IoError.
void dump(const std::string& folder, std::string name, const Shot& shot, const Pattern& pattern,
          const std::vector<Match>& matches);

}  // namespace vsfind::measure
