/// Every kernel of the fit agrees with its scalar twin, at odd lengths.
#include "finder/fit_kernels.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/finder/kernel_input.h"

namespace vsfind::kernels {
namespace {

TEST(FitKernels, SumsEqualTheScalarTwin) {
  for (const int count : lengths) {
    std::vector<Floats> columns;
    std::array<const float*, most_columns> pointers{};
    for (std::size_t c = 0; c < most_columns; ++c) {
      columns.push_back(random_floats(count, -100.0F, 100.0F, 10 + c));
      pointers[c] = columns.back().data();
    }
    const Floats weight = random_floats(count, 0.0F, 1.0F, 30);
    for (int number = 1; number <= most_columns; ++number) {
      const auto size = static_cast<std::size_t>(number * (number + 1) / 2);
      std::vector<double> fast(size), slow(size);
      normal_equations(pointers.data(), number, weight.data(), count, fast.data());
      scalar::normal_equations(pointers.data(), number, weight.data(), count, slow.data());
      for (std::size_t i = 0; i < size; ++i) EXPECT_NEAR(fast[i], slow[i], 1e-6 * 1e4 * count + 1e-3);
    }
    const Floats beta = random_floats(8, -2.0F, 2.0F, 31);
    Floats fast(weight.size()), slow(weight.size());
    residuals(pointers.data(), beta.data(), 5, columns[6].data(), count, fast.data());
    scalar::residuals(pointers.data(), beta.data(), 5, columns[6].data(), count, slow.data());
    for (std::size_t i = 0; i < fast.size(); ++i) EXPECT_NEAR(fast[i], slow[i], 1e-3F);
    tukey_weights(columns[0].data(), weight.data(), 0.02F, count, fast.data());
    scalar::tukey_weights(columns[0].data(), weight.data(), 0.02F, count, slow.data());
    for (std::size_t i = 0; i < fast.size(); ++i) EXPECT_NEAR(fast[i], slow[i], 1e-5F);
    double sums[6];
    double slow_sums[6];
    correlation_sums(columns[0].data(), columns[1].data(), weight.data(), count, sums);
    scalar::correlation_sums(columns[0].data(), columns[1].data(), weight.data(), count, slow_sums);
    for (int k = 0; k < 6; ++k) EXPECT_NEAR(sums[k], slow_sums[k], 1e-6 * 1e4 * count + 1e-3);
    EXPECT_NEAR(agreement(columns[0].data(), columns[1].data(), weight.data(), count, 0.7F, 3.0F, 0.01F),
                scalar::agreement(columns[0].data(), columns[1].data(), weight.data(), count, 0.7F, 3.0F, 0.01F),
                1e-4F * static_cast<float>(count + 1));
  }
}

TEST(FitKernels, MedianIsThatOfTheScalarTwinBitForBit) {
  for (const int count : lengths) {
    Floats residual = random_floats(count, -20.0F, 20.0F, 40);
    Floats inside(residual.size(), 1.0F);
    for (std::size_t i = 0; i < inside.size(); i += 3) inside[i] = 0.0F;
    if (count > 8) residual[1] = residual[2] = residual[4] = 0.0F;
    Floats fast(residual.size()), slow(residual.size());
    for (const float limit : {0.0F, 1e-3F, 5.0F, 12.0F, 1e30F, std::numeric_limits<float>::infinity()}) {
      const float median = median_below(residual.data(), inside.data(), limit, count, fast.data());
      EXPECT_EQ(median, scalar::median_below(residual.data(), inside.data(), limit, count, slow.data()))
          << count << ' ' << limit;
      if (limit == 0.0F) {
        EXPECT_LT(median, 0.0F);
      }
    }
  }
  const Floats known{-3.0F, 1.0F, 9.0F, -2.0F, 7.0F, 0.0F, 0.0F, 0.0F};
  const Floats all(8, 1.0F);
  Floats scratch(8);
  EXPECT_EQ(median_below(known.data(), all.data(), 100.0F, 5, scratch.data()), 3.0F);
  EXPECT_EQ(median_below(known.data(), all.data(), 8.0F, 5, scratch.data()), 3.0F);  // the upper one of four
}

TEST(FitKernels, ViewSumsEqualTheScalarTwin) {
  for (const int count : lengths) {
    const Floats residual = random_floats(count, -20.0F, 20.0F, 50);
    const Floats target = random_floats(count, -100.0F, 100.0F, 51);
    const Floats value = random_floats(count, 0.0F, 255.0F, 52);
    Floats inside(residual.size(), 1.0F);
    for (std::size_t i = 0; i < inside.size(); i += 4) inside[i] = 0.0F;
    const ViewSums fast =
        view_sums(residual.data(), target.data(), value.data(), inside.data(), count, 1.0F / 15.0F, 8.0F);
    const ViewSums slow =
        scalar::view_sums(residual.data(), target.data(), value.data(), inside.data(), count, 1.0F / 15.0F, 8.0F);
    EXPECT_EQ(fast.inside, slow.inside);
    EXPECT_EQ(fast.seen, slow.seen);
    for (int k = 0; k < 5; ++k) EXPECT_NEAR(fast.sums[k], slow.sums[k], 1e-5 * std::abs(slow.sums[k]) + 1e-3);
  }
}

}  // namespace
}  // namespace vsfind::kernels
