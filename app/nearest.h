#pragma once
/// @file
/// What the user probably meant.

#include <string>
#include <string_view>
#include <vector>

namespace vsfind {

/// Insertions, deletions, replacements and swaps of neighbours that turn `a` into `b`.
[[nodiscard]] std::size_t edit_distance(std::string_view a, std::string_view b);

/// The known name closest to `wanted`, or "" where none is close enough to be worth naming.
[[nodiscard]] std::string nearest_name(std::string_view wanted, const std::vector<std::string>& known);

/// " (did you mean NAME?)", or "" where no known name is close.
[[nodiscard]] std::string did_you_mean(std::string_view wanted, const std::vector<std::string>& known);

}  // namespace vsfind
