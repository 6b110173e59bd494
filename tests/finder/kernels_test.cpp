/// Every kernel gives the bits of its scalar twin, on the instruction set of this machine, at odd lengths and
/// misaligned.
#include "finder/kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
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
    for (const int points : {2, 24, 40, 64}) {
      auto plane = noise(40000, static_cast<std::uint64_t>(count * points));
      for (std::uint8_t& pixel : plane) pixel &= 127U;
      const std::vector<std::int8_t> weights = some_weights(points, random);
      std::vector<std::ptrdiff_t> offsets;
      for (int i = 0; i < points; ++i) offsets.push_back(static_cast<std::ptrdiff_t>(random() % 38000));
      const auto room = static_cast<std::size_t>((count + dot_block - 1) / dot_block * dot_block);
      std::vector<std::int16_t> factor(room);
      for (std::int16_t& each : factor) each = static_cast<std::int16_t>(random() % 32768);
      for (const Polarity polarity : {Polarity::same, Polarity::reversed, Polarity::any}) {
        std::vector<std::int16_t> best(room, 0), slow_best(room, 0);
        std::vector<std::uint16_t> which(room, 9), slow_which(room, 9);
        // Twice, from another place: what was better before must stay.
        for (const std::uint16_t id : {std::uint16_t{1}, std::uint16_t{65535}}) {
          const std::uint8_t* base = plane.data() + 3 + id % 7;
          best_dots(base, offsets.data(), weights.data(), points, count, polarity, factor.data(), id, best.data(),
                    which.data());
          scalar::best_dots(base, offsets.data(), weights.data(), points, count, polarity, factor.data(), id,
                            slow_best.data(), slow_which.data());
          ASSERT_EQ(best, slow_best) << count << " positions, " << points << " points, " << vsfind::name(polarity);
          ASSERT_EQ(which, slow_which);
        }
      }
    }
  }
}

TEST(Kernels, DotsDoNotOverflowAtTheExtremes) {
  const std::vector<std::uint8_t> plane(200, 127);
  const std::vector<std::ptrdiff_t> offsets(2, 0);
  const std::vector<std::int16_t> factor(dot_block, 32767);
  for (const int sign : {1, -1}) {
    const std::vector<std::int8_t> weights(2, static_cast<std::int8_t>(sign * 127));
    std::vector<std::int16_t> best(dot_block, 0);
    std::vector<std::uint16_t> which(dot_block, 0);
    best_dots(plane.data(), offsets.data(), weights.data(), 2, 5, Polarity::any, factor.data(), 1, best.data(),
              which.data());
    EXPECT_NEAR(best[4], 2 * 127 * 127 / 2, 1);
  }
}

TEST(Kernels, LocalMaximaEqualTheScalarTwin) {
  std::mt19937_64 random(5);
  std::size_t all = 0;
  for (const int count : lengths) {
    // Few values, so that many neighbours are equal.
    for (const unsigned values : {3U, 20U, 30000U}) {
      const auto room = static_cast<std::size_t>(count) + 2;
      std::vector<std::int16_t> rows(3 * room);
      for (std::int16_t& score : rows) score = static_cast<std::int16_t>(random() % values);
      const std::int16_t* row = rows.data() + room + 1;
      const auto stride = static_cast<std::ptrdiff_t>(room);
      std::vector<std::uint16_t> fast(room, 0), slow(room, 0);
      const int found = local_maxima(row - stride, row, row + stride, count, 2, fast.data());
      ASSERT_EQ(found, scalar::local_maxima(row - stride, row, row + stride, count, 2, slow.data()));
      EXPECT_EQ(fast, slow) << count << " columns, " << values << " values";
      all += static_cast<std::size_t>(found);
    }
  }
  EXPECT_GT(all, 50U);
}

TEST(Kernels, SumsInsideEqualTheScalarTwin) {
  std::mt19937_64 random(6);
  constexpr std::ptrdiff_t stride = 200;
  auto plane = noise(200 * 200, 8);
  for (std::uint8_t& pixel : plane) pixel &= 127U;
  for (const int count : {1, 4, 31, 32, 58, 96, most_sum_points}) {
    const auto room = static_cast<std::size_t>((count + sum_block - 1) / sum_block * sum_block);
    std::vector<std::int16_t> du(room, 0), dv(room, 0), weights(room, 0);
    std::vector<std::ptrdiff_t> offsets;
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      du[i] = static_cast<std::int16_t>(static_cast<int>(random() % 120) - 60);
      dv[i] = static_cast<std::int16_t>(static_cast<int>(random() % 120) - 60);
      weights[i] = static_cast<std::int16_t>(static_cast<int>(random() % 255) - 127);
      offsets.push_back(dv[i] * stride + du[i]);
    }
    const SparsePoints points{offsets.data(), du.data(), dv.data(), weights.data(), count};
    // All inside, some, none, and limits beyond what a word holds.
    for (const std::array<int, 4>& limits :
         {std::array{-60, 60, -60, 60}, std::array{-20, 60, -60, 5}, std::array{70, 80, -60, 60},
          std::array{-100000, 100000, -100000, 100000}, std::array{0, 100000, -100000, 0}}) {
      const std::uint8_t* base = plane.data() + 100 * stride + 100;
      const SparseSums fast = sums_inside(base, points, limits[0], limits[1], limits[2], limits[3]);
      const SparseSums slow = scalar::sums_inside(base, points, limits[0], limits[1], limits[2], limits[3]);
      EXPECT_EQ(fast.count, slow.count) << count << " points";
      EXPECT_EQ(fast.pixels, slow.pixels);
      EXPECT_EQ(fast.squares, slow.squares);
      EXPECT_EQ(fast.dots, slow.dots);
      EXPECT_EQ(fast.weights, slow.weights);
      EXPECT_EQ(fast.weight_squares, slow.weight_squares);
    }
  }
}

TEST(Kernels, RangeAndStretchEqualTheScalarTwin) {
  for (const int width : lengths) {
    constexpr int height = 3;
    const std::ptrdiff_t stride = width + 5;
    auto plane = noise(static_cast<std::size_t>(stride * height), static_cast<std::uint64_t>(width));
    // The rows' gaps hold what would show if they were read.
    for (std::size_t i = 0; i < plane.size(); ++i) {
      const bool gap = static_cast<std::ptrdiff_t>(i) % stride >= width;
      plane[i] =
          gap ? (i % 2 == 0 ? std::uint8_t{0} : std::uint8_t{255}) : static_cast<std::uint8_t>(20 + plane[i] % 200);
    }
    std::uint8_t least = 1, most = 2, slow_least = 3, slow_most = 4;
    range_of(plane.data(), stride, width, height, least, most);
    scalar::range_of(plane.data(), stride, width, height, slow_least, slow_most);
    EXPECT_EQ(least, slow_least) << width << " columns";
    EXPECT_EQ(most, slow_most);
    EXPECT_GE(least, 20);
    EXPECT_LT(most, 220);
    const auto factor = static_cast<std::uint16_t>(127 * 256 / std::max(1, most - least));
    std::vector<std::uint8_t> fast(static_cast<std::size_t>(width), 1), slow(static_cast<std::size_t>(width), 2);
    stretch(plane.data(), width, least, factor, fast.data());
    scalar::stretch(plane.data(), width, least, factor, slow.data());
    EXPECT_EQ(fast, slow);
    EXPECT_LE(*std::max_element(fast.begin(), fast.end()), 127);
  }
}

}  // namespace
}  // namespace vsfind::kernels
