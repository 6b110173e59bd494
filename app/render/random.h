#pragma once
/// @file
/// Random numbers that are the same on every platform: the standard fixes the generator's bits, not its distributions.

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

namespace vsfind::render {

class Random {
 public:
  explicit Random(std::uint64_t seed) : generator_(seed) {}

  /// In [0, 1).
  double uniform() { return static_cast<double>(generator_() >> 11U) * 0x1.0p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// A whole number in low … high, both included.
  int integer(int low, int high) { return low + static_cast<int>(uniform() * (high - low + 1)); }
  bool chance(double probability) { return uniform() < probability; }
  /// Mean 0, standard deviation 1 (Box and Muller 1958).
  double normal() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    const double angle = 2.0 * std::numbers::pi * uniform();
    spare_ = radius * std::sin(angle);
    has_spare_ = true;
    return radius * std::cos(angle);
  }
  std::uint64_t bits() { return generator_(); }

 private:
  std::mt19937_64 generator_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace vsfind::render
