/// Every kernel gives the bits of its scalar twin, on the instruction set of this machine, at odd lengths and
/// misaligned.
#include "finder/kernels.h"

#include <gtest/gtest.h>

#include <array>
#include <random>
#include <vector>

namespace vsfind::kernels {
namespace {

std::vector<std::uint8_t> noise(std::size_t size, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<std::uint8_t> bytes(size);
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random() >> 56U);
  return bytes;
}

constexpr std::array lengths{1, 2, 7, 15, 16, 17, 31, 32, 33, 63, 64, 65, 100, 257};

TEST(Kernels, HalvingEqualsTheScalarTwin) {
  for (const int length : lengths) {
    for (const std::size_t shift : {0U, 1U, 5U}) {
      const auto a = noise(static_cast<std::size_t>(2 * length) + shift, 1);
      const auto b = noise(static_cast<std::size_t>(2 * length) + shift, 2);
      std::vector<std::uint8_t> fast(static_cast<std::size_t>(length), 7);
      std::vector<std::uint8_t> slow(static_cast<std::size_t>(length), 9);
      halve_both(a.data() + shift, b.data() + shift, fast.data(), length);
      scalar::halve_both(a.data() + shift, b.data() + shift, slow.data(), length);
      EXPECT_EQ(fast, slow) << "both, length " << length;
      halve_x(a.data() + shift, fast.data(), length);
      scalar::halve_x(a.data() + shift, slow.data(), length);
      EXPECT_EQ(fast, slow) << "x, length " << length;
      halve_y(a.data() + shift, b.data() + shift, fast.data(), length);
      scalar::halve_y(a.data() + shift, b.data() + shift, slow.data(), length);
      EXPECT_EQ(fast, slow) << "y, length " << length;
    }
  }
}

/// Weights as the coarse search makes them: their absolute values sum to no more than most_weight.
std::vector<std::int8_t> some_weights(int points, std::mt19937_64& random) {
  std::vector<std::int8_t> weights;
  const int most = most_weight / points;
  for (int i = 0; i < points; ++i) {
    weights.push_back(
        static_cast<std::int8_t>(static_cast<int>(random() % static_cast<unsigned>(2 * most + 1)) - most));
  }
  return weights;
}

TEST(Kernels, DotsEqualTheScalarTwin) {
  std::mt19937_64 random(3);
  for (const int count : lengths) {
    for (const int points : {2, 24, 40, most_sum_points}) {
      auto plane = noise(40000, static_cast<std::uint64_t>(count * points));
      for (std::uint8_t& pixel : plane) pixel &= 127U;
      const std::vector<std::int8_t> weights = some_weights(points, random);
      std::vector<std::ptrdiff_t> offsets;
      for (int i = 0; i < points; ++i) offsets.push_back(static_cast<std::ptrdiff_t>(random() % 38000));
      const auto room = static_cast<std::size_t>((count + dot_block - 1) / dot_block * dot_block);
      std::vector<std::int16_t> factor(room), shift(room);
      for (std::size_t p = 0; p < room; ++p) {
        factor[p] = static_cast<std::int16_t>(random() % 32768);
        shift[p] = static_cast<std::int16_t>(static_cast<int>(random() % 16384) - 8192);
      }
      for (const Polarity polarity : {Polarity::same, Polarity::reversed, Polarity::any}) {
        std::vector<std::int16_t> best(room, 0), slow_best(room, 0);
        std::vector<std::uint16_t> which(room, 9), slow_which(room, 9);
        // Twice, from another place: what was better before must stay.
        for (const std::uint16_t id : {std::uint16_t{1}, std::uint16_t{65535}}) {
          const std::uint8_t* base = plane.data() + 3 + id % 7;
          best_dots(base, offsets.data(), weights.data(), points, count, polarity, id, best.data(), which.data());
          scalar::best_dots(base, offsets.data(), weights.data(), points, count, polarity, id, slow_best.data(),
                            slow_which.data());
          ASSERT_EQ(best, slow_best) << count << " positions, " << points << " points, " << vsfind::name(polarity);
          ASSERT_EQ(which, slow_which);
        }
        best_dots_inside(plane.data() + 11, offsets.data(), weights.data(), points, count, polarity, factor.data(),
                         shift.data(), 2, best.data(), which.data());
        scalar::best_dots_inside(plane.data() + 11, offsets.data(), weights.data(), points, count, polarity,
                                 factor.data(), shift.data(), 2, slow_best.data(), slow_which.data());
        ASSERT_EQ(best, slow_best) << count << " positions, " << points << " points, " << vsfind::name(polarity);
        ASSERT_EQ(which, slow_which);
      }
    }
  }
}

TEST(Kernels, DotsDoNotOverflowAtTheExtremes) {
  const std::vector<std::uint8_t> plane(200, 127);
  const std::vector<std::ptrdiff_t> offsets(2, 0);
  for (const int sign : {1, -1}) {
    const std::vector<std::int8_t> weights(2, static_cast<std::int8_t>(sign * 127));
    std::vector<std::int16_t> best(dot_block, 0);
    std::vector<std::uint16_t> which(dot_block, 0);
    best_dots(plane.data(), offsets.data(), weights.data(), 2, 5, Polarity::any, 1, best.data(), which.data());
    EXPECT_NEAR(best[4], 2 * 127 * 127 / 4, 1);
  }
}

}  // namespace
}  // namespace vsfind::kernels
