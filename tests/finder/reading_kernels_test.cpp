/// Pictures are read at points as by the scalar twins, at odd lengths and at the picture's borders.
#include "finder/reading_kernels.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

#include "tests/finder/kernel_input.h"

namespace vsfind::kernels {
namespace {

constexpr int width = 53;
constexpr int height = 41;

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

TEST(ReadingKernels, ReadingEqualsTheScalarTwin) {
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

TEST(ReadingKernels, DeepPicturesAreReadLikeTheScalarTwin) {
  const auto pixels = picture<std::uint16_t>();
  const ReadPlane plane = plane_of(pixels);
  expect_alike(
      [&](bool fast, const Places& p, int n, float* out, float* inside) {
        (fast ? read_gaussian : scalar::read_gaussian)(plane, 2, -0.5F, -1.0F, 1.0F / 256.0F, p.u.data(), p.v.data(), n,
                                                       out, inside);
      },
      1e-3F);
}

TEST(ReadingKernels, ProjectionIsAffine) {
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

TEST(ReadingKernels, AGaussianReadsARampExactly) {
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
