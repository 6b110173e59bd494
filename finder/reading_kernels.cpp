// Compiled once per instruction set by Highway's foreach_target; the HWY_ONCE part at the end picks one at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "finder/reading_kernels.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h, as Highway wants it.
#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "finder/reading_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace vsfind::kernels::HWY_NAMESPACE {
#if HWY_TARGET == HWY_SCALAR

using scalar::project;
using scalar::read_bilinear;
using scalar::read_gaussian;
using scalar::read_smoothed;

#else

namespace hn = hwy::HWY_NAMESPACE;

// 256 bits at most: point sets are short.
using Floats = hn::CappedTag<float, point_block>;
using Ints = hn::RebindToSigned<Floats>;
using Vector = hn::Vec<Floats>;
constexpr int most_lanes = point_block;

HWY_INLINE int lanes() { return static_cast<int>(hn::Lanes(Floats())); }

/// One block of points: the pixel below each, the fraction to the next, and whether the taps lie inside.
struct Block {
  alignas(32) std::int32_t x[most_lanes];
  alignas(32) std::int32_t y[most_lanes];
  Vector fraction_x;
  Vector fraction_y;
  Vector inside;  ///< 1 or 0; where 0, x and y are 0 and must not be read

  Block(const ReadPlane& plane, const float* u, const float* v, float before, float after)
      : fraction_x(hn::Zero(Floats())), fraction_y(fraction_x), inside(fraction_x) {
    const Floats floats;
    const auto pu = hn::LoadU(floats, u);
    const auto pv = hn::LoadU(floats, v);
    // Comparisons with NaN are false.
    const auto in = hn::And(hn::And(hn::Ge(pu, hn::Set(floats, plane.left + before)),
                                    hn::Lt(pu, hn::Set(floats, plane.right - after + 1.0F))),
                            hn::And(hn::Ge(pv, hn::Set(floats, plane.top + before)),
                                    hn::Lt(pv, hn::Set(floats, plane.bottom - after + 1.0F))));
    inside = hn::IfThenElseZero(in, hn::Set(floats, 1.0F));
    const auto su = hn::IfThenElseZero(in, pu);
    const auto sv = hn::IfThenElseZero(in, pv);
    const auto fu = hn::Floor(su);
    const auto fv = hn::Floor(sv);
    fraction_x = hn::Sub(su, fu);
    fraction_y = hn::Sub(sv, fv);
    const Ints ints;
    hn::Store(hn::ConvertTo(ints, fu), ints, x);
    hn::Store(hn::ConvertTo(ints, fv), ints, y);
  }
};

void project(const float* x, const float* y, int count, const float m[6], float* u, float* v) {
  const Floats floats;
  for (int i = 0; i < padded(count); i += lanes()) {
    const auto px = hn::LoadU(floats, x + i);
    const auto py = hn::LoadU(floats, y + i);
    const auto line = [&](const float* row) {
      return hn::MulAdd(hn::Set(floats, row[0]), px, hn::MulAdd(hn::Set(floats, row[1]), py, hn::Set(floats, row[2])));
    };
    hn::StoreU(line(m), floats, u + i);
    hn::StoreU(line(m + 3), floats, v + i);
  }
}

void read_bilinear(const ReadPlane& plane, const float* u, const float* v, int count, float* out, float* inside) {
  const Floats floats;
  const Ints ints;
  const int step = lanes();
  for (int i = 0; i < padded(count); i += step) {
    const Block block(plane, u + i, v + i, 0.0F, 1.0F);
    hn::StoreU(block.inside, floats, inside + i);
    // Each number holds two neighbours of a row: the left one in its low byte.
    alignas(32) std::int32_t above[most_lanes];
    alignas(32) std::int32_t below[most_lanes];
    alignas(32) float in[most_lanes];
    hn::Store(block.inside, floats, in);
    for (int k = 0; k < step; ++k) {
      above[k] = below[k] = 0;
      if (in[k] == 0.0F) continue;
      const std::byte* at = plane.base + block.y[k] * plane.stride + block.x[k];
      above[k] = std::to_integer<int>(at[0]) | std::to_integer<int>(at[1]) << 8;
      at += plane.stride;
      below[k] = std::to_integer<int>(at[0]) | std::to_integer<int>(at[1]) << 8;
    }
    const auto low = hn::Set(ints, 0xFF);
    const auto row = [&](const std::int32_t* pair) {
      const auto both = hn::Load(ints, pair);
      const auto left = hn::ConvertTo(floats, hn::And(both, low));
      const auto right = hn::ConvertTo(floats, hn::ShiftRight<8>(both));
      return hn::MulAdd(block.fraction_x, hn::Sub(right, left), left);
    };
    const auto top = row(above);
    hn::StoreU(hn::MulAdd(block.fraction_y, hn::Sub(row(below), top), top), floats, out + i);
  }
}

void read_smoothed(const ReadPlane& plane, const float* u, const float* v, int count, float* out, float* inside) {
  const Floats floats;
  const hn::CappedTag<float, 4> four;
  const hn::Rebind<std::int32_t, decltype(four)> four_ints;
  const hn::Rebind<std::uint8_t, decltype(four)> four_bytes;
  const int step = lanes();
  for (int i = 0; i < padded(count); i += step) {
    const Block block(plane, u + i, v + i, 1.0F, 2.0F);
    hn::StoreU(block.inside, floats, inside + i);
    alignas(32) float a[most_lanes];
    alignas(32) float b[most_lanes];
    alignas(32) float in[most_lanes];
    hn::Store(block.fraction_x, floats, a);
    hn::Store(block.fraction_y, floats, b);
    hn::Store(block.inside, floats, in);
    for (int k = 0; k < step; ++k) {
      out[i + k] = 0.0F;
      if (in[k] == 0.0F) continue;
      const std::byte* at = plane.base + (block.y[k] - 1) * plane.stride + (block.x[k] - 1);
      const auto row = [&](const std::byte* p) {
        std::uint8_t bytes[16];
        std::memcpy(bytes, p, 4);
        return hn::ConvertTo(four, hn::PromoteTo(four_ints, hn::LoadU(four_bytes, bytes)));
      };
      auto sum = hn::Mul(hn::Set(four, 1.0F - b[k]), row(at));
      sum = hn::MulAdd(hn::Set(four, 2.0F - b[k]), row(at + plane.stride), sum);
      sum = hn::MulAdd(hn::Set(four, 1.0F + b[k]), row(at + 2 * plane.stride), sum);
      sum = hn::MulAdd(hn::Set(four, b[k]), row(at + 3 * plane.stride), sum);
      alignas(16) float s[4];
      hn::Store(sum, four, s);
      out[i + k] = ((1.0F - a[k]) * s[0] + (2.0F - a[k]) * s[1] + (1.0F + a[k]) * s[2] + a[k] * s[3]) * (1.0F / 16.0F);
    }
  }
}

/// Weights of the taps −3 … 4 for a block of points, weights[tap][point], normalized.
/// exp(k·(d−f)²) = exp(k·d²) · exp(−2·k·f)^d · exp(k·f²), and the last factor falls out with the normalization.
void tap_weights(const Vector& fraction, float k, const float* at_whole, float weights[8][most_lanes]) {
  const Floats floats;
  const auto up = hn::Exp(floats, hn::Mul(fraction, hn::Set(floats, -2.0F * k)));
  const auto down = hn::Div(hn::Set(floats, 1.0F), up);
  const auto up2 = hn::Mul(up, up);
  const auto down2 = hn::Mul(down, down);
  const Vector powers[8] = {hn::Mul(down2, down), down2, down, hn::Set(floats, 1.0F), up, up2, hn::Mul(up2, up),
                            hn::Mul(up2, up2)};
  auto total = hn::Zero(floats);
  for (int d = 0; d < 8; ++d) total = hn::MulAdd(powers[d], hn::Set(floats, at_whole[d]), total);
  const auto norm = hn::Div(hn::Set(floats, 1.0F), total);
  for (int d = 0; d < 8; ++d) {
    hn::Store(hn::Mul(hn::Mul(powers[d], hn::Set(floats, at_whole[d])), norm), floats, weights[d]);
  }
}

/// For each point of a block the sum of its columns, weighted: the columns are exchanged between the vectors of eight
/// points until each vector holds one column of all points.
template <typename D = Floats>
HWY_INLINE hn::Vec<D> weighted_columns(const float columns[most_lanes][8], const float weights[8][most_lanes]) {
  const D floats;
  auto sum = hn::Zero(floats);
  if constexpr (hn::MaxLanes(D()) == 8) {
    const hn::Repartition<double, D> pairs;
    const auto pair = [&](hn::Vec<D> v) { return hn::BitCast(pairs, v); };
    hn::Vec<D> quads[8];
    for (int k = 0; k < 8; k += 4) {
      const auto a = hn::Load(floats, columns[k]);
      const auto b = hn::Load(floats, columns[k + 1]);
      const auto c = hn::Load(floats, columns[k + 2]);
      const auto d = hn::Load(floats, columns[k + 3]);
      const auto ab_low = pair(hn::InterleaveLower(floats, a, b));
      const auto ab_high = pair(hn::InterleaveUpper(floats, a, b));
      const auto cd_low = pair(hn::InterleaveLower(floats, c, d));
      const auto cd_high = pair(hn::InterleaveUpper(floats, c, d));
      // Columns 0 and 4, 1 and 5, … of four points.
      quads[k] = hn::BitCast(floats, hn::InterleaveLower(pairs, ab_low, cd_low));
      quads[k + 1] = hn::BitCast(floats, hn::InterleaveUpper(pairs, ab_low, cd_low));
      quads[k + 2] = hn::BitCast(floats, hn::InterleaveLower(pairs, ab_high, cd_high));
      quads[k + 3] = hn::BitCast(floats, hn::InterleaveUpper(pairs, ab_high, cd_high));
    }
    for (int d = 0; d < 4; ++d) {
      sum = hn::MulAdd(hn::ConcatLowerLower(floats, quads[d + 4], quads[d]), hn::Load(floats, weights[d]), sum);
      sum = hn::MulAdd(hn::ConcatUpperUpper(floats, quads[d + 4], quads[d]), hn::Load(floats, weights[d + 4]), sum);
    }
  } else {
    alignas(32) float sums[most_lanes] = {};
    for (int k = 0; k < lanes(); ++k) {
      for (int d = 0; d < 8; ++d) sums[k] += columns[k][d] * weights[d][k];
    }
    sum = hn::Load(floats, sums);
  }
  return sum;
}

template <typename Pixel>
void read_gaussian_of(const ReadPlane& plane, float kx, float ky, float scale, const float* u, const float* v,
                      int count, float* out, float* inside) {
  const Floats floats;
  const Ints ints;
  const hn::Rebind<Pixel, Floats> pixels;
  constexpr auto bytes = static_cast<std::ptrdiff_t>(sizeof(Pixel));
  float whole_x[8];
  float whole_y[8];
  for (int d = 0; d < 8; ++d) {
    const auto squared = static_cast<float>((d - 3) * (d - 3));
    whole_x[d] = hn::GetLane(hn::Exp(floats, hn::Set(floats, kx * squared)));
    whole_y[d] = hn::GetLane(hn::Exp(floats, hn::Set(floats, ky * squared)));
  }
  const int step = lanes();
  for (int i = 0; i < padded(count); i += step) {
    const Block block(plane, u + i, v + i, 3.0F, 4.0F);
    hn::StoreU(block.inside, floats, inside + i);
    alignas(32) float wx[8][most_lanes];
    alignas(32) float wy[8][most_lanes];
    alignas(32) float in[most_lanes];
    tap_weights(block.fraction_x, kx, whole_x, wx);
    tap_weights(block.fraction_y, ky, whole_y, wy);
    hn::Store(block.inside, floats, in);
    // What is left of each point's eight rows: a sum for each of its columns.
    alignas(32) float columns[most_lanes][8];
    for (int k = 0; k < step; ++k) {
      if (in[k] == 0.0F) {
        std::fill_n(columns[k], 8, 0.0F);
        continue;
      }
      const std::byte* first = plane.base + (block.y[k] - 3) * plane.stride + (block.x[k] - 3) * bytes;
      for (int half = 0; half < 8; half += step) {
        const std::byte* at = first + half * bytes;
        // Two sums, which do not wait for each other.
        auto even = hn::Zero(floats);
        auto odd = even;
        const auto line = [&](int d) {
          const auto row = hn::LoadU(pixels, reinterpret_cast<const Pixel*>(at + d * plane.stride));
          return hn::ConvertTo(floats, hn::PromoteTo(ints, row));
        };
        for (int d = 0; d < 8; d += 2) {
          even = hn::MulAdd(hn::Set(floats, wy[d][k]), line(d), even);
          odd = hn::MulAdd(hn::Set(floats, wy[d + 1][k]), line(d + 1), odd);
        }
        hn::Store(hn::Add(even, odd), floats, columns[k] + half);
      }
    }
    hn::StoreU(hn::Mul(hn::Set(floats, scale), weighted_columns(columns, wx)), floats, out + i);
  }
}

void read_gaussian(const ReadPlane& plane, int pixel_bytes, float kx, float ky, float scale, const float* u,
                   const float* v, int count, float* out, float* inside) {
  if (pixel_bytes == 1) {
    read_gaussian_of<std::uint8_t>(plane, kx, ky, scale, u, v, count, out, inside);
  } else {
    read_gaussian_of<std::uint16_t>(plane, kx, ky, scale, u, v, count, out, inside);
  }
}

#endif  // HWY_TARGET == HWY_SCALAR

}  // namespace vsfind::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vsfind::kernels {

HWY_EXPORT(project);
HWY_EXPORT(read_bilinear);
HWY_EXPORT(read_smoothed);
HWY_EXPORT(read_gaussian);

void project(const float* x, const float* y, int count, const float m[6], float* u, float* v) {
  HWY_DYNAMIC_DISPATCH(project)(x, y, count, m, u, v);
}
void read_bilinear(const ReadPlane& plane, const float* u, const float* v, int count, float* out, float* inside) {
  HWY_DYNAMIC_DISPATCH(read_bilinear)(plane, u, v, count, out, inside);
}
void read_smoothed(const ReadPlane& plane, const float* u, const float* v, int count, float* out, float* inside) {
  HWY_DYNAMIC_DISPATCH(read_smoothed)(plane, u, v, count, out, inside);
}
void read_gaussian(const ReadPlane& plane, int pixel_bytes, float kx, float ky, float scale, const float* u,
                   const float* v, int count, float* out, float* inside) {
  HWY_DYNAMIC_DISPATCH(read_gaussian)(plane, pixel_bytes, kx, ky, scale, u, v, count, out, inside);
}

}  // namespace vsfind::kernels
#endif
