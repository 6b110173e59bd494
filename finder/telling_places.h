#pragma once
/// @file
/// Where a pattern differs from something that looks like it.

#include <vector>

namespace vsfind {

/// 1 for each candidate that reads `view` of the look-alike clearly otherwise than `values` of the pattern, once
/// brightness and contrast are made alike: by more than three quarters of the greatest difference.
[[nodiscard]] std::vector<char> telling_places(const std::vector<float>& values, const std::vector<float>& view);

}  // namespace vsfind
