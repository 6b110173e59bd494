#pragma once
/// @file
/// What the tests of the kernels feed them: arrays as in point_block.h of every awkward length.

#include <array>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "finder/point_block.h"

namespace vsfind::kernels {

inline constexpr std::array lengths{1, 2, 7, 8, 9, 15, 16, 17, 100};

using Floats = std::vector<float>;

inline Floats random_floats(int count, float low, float high, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<float> value(low, high);
  Floats floats(static_cast<std::size_t>(padded(count)));
  for (float& each : floats) each = value(random);
  return floats;
}

}  // namespace vsfind::kernels
