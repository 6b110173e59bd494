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

TEST(Kernels, CorrelationEqualsTheScalarTwin) {
  std::mt19937_64 random(3);
  for (const int count : lengths) {
    for (const int points : {2, 24, 58, max_points}) {
      const auto picture = noise(40000, static_cast<std::uint64_t>(count * points));
      std::vector<std::ptrdiff_t> offsets;
      std::vector<std::int16_t> weights;
      for (int i = 0; i < points; ++i) {
        offsets.push_back(static_cast<std::ptrdiff_t>(random() % 38000));
        weights.push_back(static_cast<std::int16_t>(static_cast<int>(random() % 255) - 127));
      }
      const auto room = static_cast<std::size_t>((count + 31) / 32 * 32);
      std::vector<std::int32_t> sum(room), square(room), dot(room), slow_sum(room), slow_square(room), slow_dot(room);
      correlate_row(picture.data() + 3, offsets.data(), weights.data(), points, count, sum.data(), square.data(),
                    dot.data());
      scalar::correlate_row(picture.data() + 3, offsets.data(), weights.data(), points, count, slow_sum.data(),
                            slow_square.data(), slow_dot.data());
      for (std::size_t p = 0; p < static_cast<std::size_t>(count); ++p) {
        ASSERT_EQ(sum[p], slow_sum[p]) << "position " << p << " of " << count << ", " << points << " points";
        ASSERT_EQ(square[p], slow_square[p]);
        ASSERT_EQ(dot[p], slow_dot[p]);
      }
    }
  }
}

TEST(Kernels, SumsDoNotOverflowAtTheExtremes) {
  for (const std::uint8_t grey : {std::uint8_t{0}, std::uint8_t{255}}) {
    const std::vector<std::uint8_t> picture(200, grey);
    const std::vector<std::ptrdiff_t> offsets(max_points, 0);
    const std::vector<std::int16_t> weights(max_points, 127);
    std::vector<std::int32_t> sum(32), square(32), dot(32);
    correlate_row(picture.data(), offsets.data(), weights.data(), max_points, 5, sum.data(), square.data(), dot.data());
    const int v = grey - 128;
    EXPECT_EQ(sum[4], max_points * v);
    EXPECT_EQ(square[4], max_points * v * v);
    EXPECT_EQ(dot[4], max_points * v * 127);
  }
}

}  // namespace
}  // namespace vsfind::kernels
