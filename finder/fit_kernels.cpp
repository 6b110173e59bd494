// Compiled once per instruction set by Highway's foreach_target; the HWY_ONCE part at the end picks one at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "finder/fit_kernels.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h, as Highway wants it.
#include <hwy/highway.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <limits>

#include "finder/fit_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace vsfind::kernels::HWY_NAMESPACE {
#if HWY_TARGET == HWY_SCALAR

using scalar::agreement;
using scalar::correlation_sums;
using scalar::median_below;
using scalar::normal_equations;
using scalar::residuals;
using scalar::tukey_weights;
using scalar::view_sums;

#else

namespace hn = hwy::HWY_NAMESPACE;

// 256 bits at most: point sets are short.
using Floats = hn::CappedTag<float, point_block>;
using Vector = hn::Vec<Floats>;

HWY_INLINE int lanes() { return static_cast<int>(hn::Lanes(Floats())); }

void residuals(const float* const* columns, const float* beta, int number, const float* value, int count,
               float* residual) {
  const Floats floats;
  for (int i = 0; i < padded(count); i += lanes()) {
    auto r = hn::LoadU(floats, value + i);
    for (int c = 0; c < number; ++c) r = hn::NegMulAdd(hn::LoadU(floats, columns[c] + i), hn::Set(floats, beta[c]), r);
    hn::StoreU(r, floats, residual + i);
  }
}

void tukey_weights(const float* residual, const float* inside, float inverse_cut, int count, float* weight) {
  const Floats floats;
  const auto one = hn::Set(floats, 1.0F);
  for (int i = 0; i < padded(count); i += lanes()) {
    const auto e = hn::Mul(hn::LoadU(floats, residual + i), hn::Set(floats, inverse_cut));
    const auto keep = hn::Max(hn::Zero(floats), hn::NegMulAdd(e, e, one));
    hn::StoreU(hn::Mul(hn::LoadU(floats, inside + i), hn::Mul(keep, keep)), floats, weight + i);
  }
}

/// Four neighbouring entries of a row of the normal equations.
struct RowEntries {
  Vector a;
  Vector b;
  Vector c;
  Vector d;

  // Not left to the compiler, which would make it for another instruction set.
  HWY_INLINE RowEntries() : a(hn::Zero(Floats())), b(a), c(a), d(a) {}

  HWY_INLINE void add(Vector row, Vector first, Vector second, Vector third, Vector fourth) {
    a = hn::MulAdd(row, first, a);
    b = hn::MulAdd(row, second, b);
    c = hn::MulAdd(row, third, c);
    d = hn::MulAdd(row, fourth, d);
  }

  HWY_INLINE void store(double out[4]) const {
    // All four sums at once: lanes are exchanged between the vectors until each lane belongs to one of them.
    const Quarter four;
    const auto ab = pairs(halved(a), halved(b));
    const auto cd = pairs(halved(c), halved(d));
    alignas(16) float sums[4];
    hn::Store(hn::Add(hn::ConcatLowerLower(four, cd, ab), hn::ConcatUpperUpper(four, cd, ab)), four, sums);
    for (int k = 0; k < 4; ++k) out[k] = static_cast<double>(sums[k]);
  }

 private:
  using Quarter = hn::CappedTag<float, 4>;
  using Four = hn::Vec<Quarter>;

  template <typename V>
  static HWY_INLINE Four halved(V v) {
    if constexpr (hn::MaxLanes(hn::DFromV<V>()) == 8) {
      return hn::Add(hn::LowerHalf(Quarter(), v), hn::UpperHalf(Quarter(), v));
    } else {
      return v;
    }
  }
  /// (p0 + p2, q0 + q2, p1 + p3, q1 + q3).
  static HWY_INLINE Four pairs(Four p, Four q) {
    return hn::Add(hn::InterleaveLower(Quarter(), p, q), hn::InterleaveUpper(Quarter(), p, q));
  }
};

/// Up to three rows of four entries at a time: as much as the registers hold, so that sums do not wait for each other.
template <int rows>
void entries_of(const float* const* row, const float* const* column, const float* weight, int count, double out[3][4]) {
  const Floats floats;
  RowEntries x;
  RowEntries y;
  RowEntries z;
  for (int i = 0; i < padded(count); i += lanes()) {
    const auto w = hn::LoadU(floats, weight + i);
    const auto c0 = hn::LoadU(floats, column[0] + i);
    const auto c1 = hn::LoadU(floats, column[1] + i);
    const auto c2 = hn::LoadU(floats, column[2] + i);
    const auto c3 = hn::LoadU(floats, column[3] + i);
    x.add(hn::Mul(w, hn::LoadU(floats, row[0] + i)), c0, c1, c2, c3);
    if constexpr (rows > 1) y.add(hn::Mul(w, hn::LoadU(floats, row[1] + i)), c0, c1, c2, c3);
    if constexpr (rows > 2) z.add(hn::Mul(w, hn::LoadU(floats, row[2] + i)), c0, c1, c2, c3);
  }
  x.store(out[0]);
  if constexpr (rows > 1) y.store(out[1]);
  if constexpr (rows > 2) z.store(out[2]);
}

void normal_equations(const float* const* columns, int number, const float* weight, int count, double* lower) {
  for (int r = 0; r < number; r += 3) {
    const int rows = std::min(3, number - r);
    for (int s = 0; s < r + rows; s += 4) {
      // What is computed above the diagonal is not kept.
      const float* column[4];
      for (int k = 0; k < 4; ++k) column[k] = columns[std::min(s + k, number - 1)];
      double entries[3][4];
      const auto compute = rows == 3 ? entries_of<3> : rows == 2 ? entries_of<2> : entries_of<1>;
      compute(columns + r, column, weight, count, entries);
      for (int i = 0; i < rows; ++i) {
        for (int k = 0; k < 4 && s + k <= r + i; ++k) lower[(r + i) * (r + i + 1) / 2 + s + k] = entries[i][k];
      }
    }
  }
}

void correlation_sums(const float* value, const float* target, const float* inside, int count, double sums[6]) {
  const Floats floats;
  Vector s[6] = {hn::Zero(floats), hn::Zero(floats), hn::Zero(floats),
                 hn::Zero(floats), hn::Zero(floats), hn::Zero(floats)};
  for (int i = 0; i < padded(count); i += lanes()) {
    const auto w = hn::LoadU(floats, inside + i);
    const auto a = hn::LoadU(floats, value + i);
    const auto b = hn::LoadU(floats, target + i);
    const auto wa = hn::Mul(w, a);
    const auto wb = hn::Mul(w, b);
    s[0] = hn::Add(s[0], w);
    s[1] = hn::Add(s[1], wa);
    s[2] = hn::Add(s[2], wb);
    s[3] = hn::MulAdd(wa, a, s[3]);
    s[4] = hn::MulAdd(wb, b, s[4]);
    s[5] = hn::MulAdd(wa, b, s[5]);
  }
  for (int k = 0; k < 6; ++k) sums[k] = static_cast<double>(hn::GetLane(hn::SumOfLanes(floats, s[k])));
}

float agreement(const float* value, const float* target, const float* inside, int count, float gain, float offset,
                float inverse_cut) {
  const Floats floats;
  auto sum = hn::Zero(floats);
  for (int i = 0; i < padded(count); i += lanes()) {
    const auto off =
        hn::Sub(hn::NegMulAdd(hn::LoadU(floats, target + i), hn::Set(floats, gain), hn::LoadU(floats, value + i)),
                hn::Set(floats, offset));
    const auto e = hn::Mul(off, hn::Set(floats, inverse_cut));
    const auto near = hn::Max(hn::Zero(floats), hn::NegMulAdd(e, e, hn::Set(floats, 1.0F)));
    sum = hn::MulAdd(hn::LoadU(floats, inside + i), near, sum);
  }
  return hn::GetLane(hn::SumOfLanes(floats, sum));
}

float median_below(const float* residual, const float* inside, float limit, int count, float* scratch) {
  const Floats floats;
  const auto far = hn::Set(floats, std::numeric_limits<float>::infinity());
  const auto below = hn::Set(floats, limit);
  const auto none = hn::Zero(floats);
  const auto numbers = hn::Iota(floats, 0.0F);
  const int step = lanes();
  std::size_t number = 0;
  for (int i = 0; i < count; i += step) {
    const auto off = hn::Abs(hn::LoadU(floats, residual + i));
    const auto counts = hn::And(hn::And(hn::Gt(hn::LoadU(floats, inside + i), none), hn::Lt(off, below)),
                                hn::Lt(numbers, hn::Set(floats, static_cast<float>(count - i))));
    number += hn::CountTrue(floats, counts);
    hn::StoreU(hn::IfThenElse(counts, off, far), floats, scratch + i);
  }
  if (number == 0) return -1.0F;
  // Positive numbers are ordered like their bits: the smallest that has more than half of them at or below itself.
  const auto number_of = [](std::uint32_t bits) {
    float value = 0.0F;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  };
  std::uint32_t low = 0;
  std::uint32_t high = 0;
  std::memcpy(&high, &limit, sizeof high);
  while (low < high) {
    const std::uint32_t middle = low + (high - low) / 2;
    const auto bound = hn::Set(floats, number_of(middle));
    std::size_t within = 0;
    for (int i = 0; i < count; i += step)
      within += hn::CountTrue(floats, hn::Le(hn::LoadU(floats, scratch + i), bound));
    if (within > number / 2) {
      high = middle;
    } else {
      low = middle + 1;
    }
  }
  return number_of(low);
}

ViewSums view_sums(const float* residual, const float* target, const float* value, const float* inside, int count,
                   float inverse_cut, float visible_within) {
  const Floats floats;
  const auto none = hn::Zero(floats);
  const auto near = hn::Set(floats, visible_within);
  const auto cut = hn::Set(floats, inverse_cut);
  const auto numbers = hn::Iota(floats, 0.0F);
  Vector sums[5] = {none, none, none, none, none};
  std::size_t all = 0;
  std::size_t seen = 0;
  for (int i = 0; i < count; i += lanes()) {
    const auto r = hn::LoadU(floats, residual + i);
    const auto t = hn::LoadU(floats, target + i);
    const auto v = hn::LoadU(floats, value + i);
    const auto in = hn::And(hn::Gt(hn::LoadU(floats, inside + i), none),
                            hn::Lt(numbers, hn::Set(floats, static_cast<float>(count - i))));
    all += hn::CountTrue(floats, in);
    seen += hn::CountTrue(floats, hn::And(in, hn::Le(hn::Abs(r), near)));
    const auto e = hn::Mul(r, cut);
    const auto keep = hn::Max(none, hn::NegMulAdd(e, e, hn::Set(floats, 1.0F)));
    const auto w = hn::IfThenElseZero(in, hn::Mul(keep, keep));
    const auto wv = hn::Mul(w, v);
    sums[0] = hn::Add(sums[0], w);
    sums[1] = hn::MulAdd(hn::Mul(w, t), t, sums[1]);
    sums[2] = hn::MulAdd(hn::Mul(w, r), r, sums[2]);
    sums[3] = hn::Add(sums[3], wv);
    sums[4] = hn::MulAdd(wv, v, sums[4]);
  }
  ViewSums view;
  view.inside = static_cast<int>(all);
  view.seen = static_cast<int>(seen);
  for (int k = 0; k < 5; ++k) view.sums[k] = static_cast<double>(hn::GetLane(hn::SumOfLanes(floats, sums[k])));
  return view;
}

#endif  // HWY_TARGET == HWY_SCALAR

}  // namespace vsfind::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vsfind::kernels {

HWY_EXPORT(residuals);
HWY_EXPORT(tukey_weights);
HWY_EXPORT(normal_equations);
HWY_EXPORT(correlation_sums);
HWY_EXPORT(agreement);
HWY_EXPORT(median_below);
HWY_EXPORT(view_sums);

void residuals(const float* const* columns, const float* beta, int number, const float* value, int count,
               float* residual) {
  HWY_DYNAMIC_DISPATCH(residuals)(columns, beta, number, value, count, residual);
}
void tukey_weights(const float* residual, const float* inside, float inverse_cut, int count, float* weight) {
  HWY_DYNAMIC_DISPATCH(tukey_weights)(residual, inside, inverse_cut, count, weight);
}
void normal_equations(const float* const* columns, int number, const float* weight, int count, double* lower) {
  HWY_DYNAMIC_DISPATCH(normal_equations)(columns, number, weight, count, lower);
}
void correlation_sums(const float* value, const float* target, const float* inside, int count, double sums[6]) {
  HWY_DYNAMIC_DISPATCH(correlation_sums)(value, target, inside, count, sums);
}
float agreement(const float* value, const float* target, const float* inside, int count, float gain, float offset,
                float inverse_cut) {
  return HWY_DYNAMIC_DISPATCH(agreement)(value, target, inside, count, gain, offset, inverse_cut);
}
float median_below(const float* residual, const float* inside, float limit, int count, float* scratch) {
  return HWY_DYNAMIC_DISPATCH(median_below)(residual, inside, limit, count, scratch);
}
ViewSums view_sums(const float* residual, const float* target, const float* value, const float* inside, int count,
                   float inverse_cut, float visible_within) {
  return HWY_DYNAMIC_DISPATCH(view_sums)(residual, target, value, inside, count, inverse_cut, visible_within);
}

}  // namespace vsfind::kernels
#endif
