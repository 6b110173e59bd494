/// Every kernel of the fit agrees with its scalar twin, at odd lengths and at the picture's borders.
#include "finder/fit_kernels.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace vsfind::kernels {
namespace {

constexpr std::array lengths{1, 2, 7, 8, 9, 15, 16, 17, 100};
constexpr int width = 53;
constexpr int height = 41;

using Floats = std::vector<float>;

Floats random_floats(int count, float low, float high, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<float> value(low, high);
  Floats floats(static_cast<std::size_t>(padded(count)));
  for (float& each : floats) each = value(random);
  return floats;
}

template <typename Pixel>
std::vector<Pixel> picture() {
  std::mt19937_64 random(5);
  std::vector<Pixel> pixels(static_cast<std::size_t>(width) * height);
  for (Pixel& pixel : pixels) pixel = static_cast<Pixel>(random() >> 40U);
  return pixels;
}

/// The picture around its pixel (20, 15).
template <typename Pixel>
ReadPlane plane_of(const std::vector<Pixel>& pixels) {
  ReadPlane plane;
  plane.base = reinterpret_cast<const std::byte*>(pixels.data() + 15 * width + 20);
  plane.stride = static_cast<std::ptrdiff_t>(sizeof(Pixel)) * width;
  plane.left = -20.0F;
  plane.top = -15.0F;
  plane.right = width - 1 - 20.0F;
  plane.bottom = height - 1 - 15.0F;
  return plane;
}

/// Places all over the picture and beyond, among them whole pixels, the borders themselves and NaN.
struct Places {
  Floats u;
  Floats v;
  explicit Places(int count) : u(random_floats(count, -25.0F, 37.0F, 1)), v(random_floats(count, -20.0F, 30.0F, 2)) {
    u[0] = -20.0F;
    v[0] = -15.0F;
    if (count > 4) {
      u[1] = 3.0F;
      v[1] = 4.0F;
      u[2] = std::numeric_limits<float>::quiet_NaN();
      u[3] = width - 1 - 20.0F;
      u[4] = -17.0F;
      v[4] = -12.0F;
    }
  }
};

template <typename Read>
void expect_alike(Read read, float tolerance) {
  for (const int count : lengths) {
    const Places places(count);
    const auto size = places.u.size();
    Floats fast(size, -1.0F), slow(size, -2.0F), fast_inside(size, -1.0F), slow_inside(size, -2.0F);
    read(true, places, count, fast.data(), fast_inside.data());
    read(false, places, count, slow.data(), slow_inside.data());
    EXPECT_EQ(fast_inside, slow_inside);
    for (std::size_t i = 0; i < size; ++i) EXPECT_NEAR(fast[i], slow[i], tolerance) << i << " of " << count;
  }
}

TEST(FitKernels, ReadingEqualsTheScalarTwin) {
  const auto pixels = picture<std::uint8_t>();
  const ReadPlane plane = plane_of(pixels);
  expect_alike(
      [&](bool fast, const Places& p, int n, float* out, float* inside) {
        (fast ? read_bilinear : scalar::read_bilinear)(plane, p.u.data(), p.v.data(), n, out, inside);
      },
      1e-3F);
  expect_alike(
      [&](bool fast, const Places& p, int n, float* out, float* inside) {
        (fast ? read_smoothed : scalar::read_smoothed)(plane, p.u.data(), p.v.data(), n, out, inside);
      },
      1e-3F);
  expect_alike(
      [&](bool fast, const Places& p, int n, float* out, float* inside) {
        (fast ? read_gaussian : scalar::read_gaussian)(plane, 1, -0.5F, -0.8F, 1.0F, p.u.data(), p.v.data(), n, out,
                                                       inside);
      },
      1e-3F);
}

TEST(FitKernels, DeepPicturesAreReadLikeTheScalarTwin) {
  const auto pixels = picture<std::uint16_t>();
  const ReadPlane plane = plane_of(pixels);
  expect_alike(
      [&](bool fast, const Places& p, int n, float* out, float* inside) {
        (fast ? read_gaussian : scalar::read_gaussian)(plane, 2, -0.5F, -1.0F, 1.0F / 256.0F, p.u.data(), p.v.data(), n,
                                                       out, inside);
      },
      1e-3F);
}

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

TEST(FitKernels, ProjectionIsAffine) {
  const Floats x = random_floats(17, -100.0F, 100.0F, 1);
  const Floats y = random_floats(17, -100.0F, 100.0F, 2);
  const float m[6] = {0.9F, -0.3F, 0.25F, 0.31F, 0.88F, -0.4F};
  Floats u(x.size()), v(x.size()), slow_u(x.size()), slow_v(x.size());
  project(x.data(), y.data(), 17, m, u.data(), v.data());
  scalar::project(x.data(), y.data(), 17, m, slow_u.data(), slow_v.data());
  for (std::size_t i = 0; i < u.size(); ++i) {
    EXPECT_NEAR(u[i], slow_u[i], 1e-4F);
    EXPECT_NEAR(v[i], slow_v[i], 1e-4F);
  }
}

TEST(FitKernels, AGaussianReadsARampExactly) {
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(width) * height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x)
      pixels[static_cast<std::size_t>(y * width + x)] = static_cast<std::uint8_t>(2 * x + y);
  }
  const ReadPlane plane = plane_of(pixels);
  const Floats u(8, 1.0F);
  const Floats v(8, -2.0F);
  Floats out(8), inside(8);
  read_gaussian(plane, 1, -0.5F, -0.5F, 1.0F, u.data(), v.data(), 8, out.data(), inside.data());
  // Taps −3 … 4 are lopsided by the one at 4, whose weight is 0.00013.
  EXPECT_NEAR(out[0], 2.0F * 21.0F + 13.0F, 0.005F);
}

}  // namespace
}  // namespace vsfind::kernels
