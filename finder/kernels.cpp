// Compiled once per instruction set by Highway's foreach_target; the HWY_ONCE part at the end picks one at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "finder/kernels.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h, as Highway wants it.
#include <hwy/highway.h>

#include <cstring>

#include "finder/kernels.h"

HWY_BEFORE_NAMESPACE();
namespace vsfind::kernels::HWY_NAMESPACE {
#if HWY_TARGET == HWY_SCALAR

using scalar::correlate_row;
using scalar::halve_both;
using scalar::halve_x;
using scalar::halve_y;

#else

namespace hn = hwy::HWY_NAMESPACE;

// 256 bits at most: wider registers gain nothing on rows this short.
using BytesTag = hn::CappedTag<std::uint8_t, 32>;
using WordsTag = hn::CappedTag<std::int16_t, 16>;
using HalfBytesTag = hn::CappedTag<std::uint8_t, 16>;
using SumsTag = hn::CappedTag<std::int32_t, 8>;

void halve_both(const std::uint8_t* a, const std::uint8_t* b, std::uint8_t* out, int count) {
  const BytesTag bytes;
  const hn::Repartition<std::uint16_t, BytesTag> words;
  const int lanes = static_cast<int>(hn::Lanes(words));
  const auto low = hn::Set(words, std::uint16_t{0x00FF});
  const auto two = hn::Set(words, std::uint16_t{2});
  const hn::Rebind<std::uint8_t, decltype(words)> narrow;
  std::ptrdiff_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    const auto va = hn::BitCast(words, hn::LoadU(bytes, a + 2 * i));
    const auto vb = hn::BitCast(words, hn::LoadU(bytes, b + 2 * i));
    const auto sum =
        hn::Add(hn::Add(hn::And(va, low), hn::ShiftRight<8>(va)), hn::Add(hn::And(vb, low), hn::ShiftRight<8>(vb)));
    const auto mean = hn::ShiftRight<2>(hn::Add(sum, two));
    hn::StoreU(hn::DemoteTo(narrow, hn::BitCast(hn::RebindToSigned<decltype(words)>(), mean)), narrow, out + i);
  }
  if (i < count) scalar::halve_both(a + 2 * i, b + 2 * i, out + i, static_cast<int>(count - i));
}

void halve_x(const std::uint8_t* a, std::uint8_t* out, int count) {
  const BytesTag bytes;
  const hn::Repartition<std::uint16_t, BytesTag> words;
  const int lanes = static_cast<int>(hn::Lanes(words));
  const auto low = hn::Set(words, std::uint16_t{0x00FF});
  const auto one = hn::Set(words, std::uint16_t{1});
  const hn::Rebind<std::uint8_t, decltype(words)> narrow;
  std::ptrdiff_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    const auto va = hn::BitCast(words, hn::LoadU(bytes, a + 2 * i));
    const auto mean = hn::ShiftRight<1>(hn::Add(hn::Add(hn::And(va, low), hn::ShiftRight<8>(va)), one));
    hn::StoreU(hn::DemoteTo(narrow, hn::BitCast(hn::RebindToSigned<decltype(words)>(), mean)), narrow, out + i);
  }
  if (i < count) scalar::halve_x(a + 2 * i, out + i, static_cast<int>(count - i));
}

void halve_y(const std::uint8_t* a, const std::uint8_t* b, std::uint8_t* out, int count) {
  const BytesTag bytes;
  const int lanes = static_cast<int>(hn::Lanes(bytes));
  std::ptrdiff_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    hn::StoreU(hn::AverageRound(hn::LoadU(bytes, a + i), hn::LoadU(bytes, b + i)), bytes, out + i);
  }
  if (i < count) scalar::halve_y(a + i, b + i, out + i, static_cast<int>(count - i));
}

#if HWY_ARCH_X86 && HWY_TARGET != HWY_EMU128

// Two points at a time: their pixels are interleaved, so that one multiply-add of pairs serves both.
void correlate_row(const std::uint8_t* base, const std::ptrdiff_t* offsets, const std::int16_t* weights, int points,
                   int count, std::int32_t* sum, std::int32_t* square, std::int32_t* dot) {
  const WordsTag words;
  const SumsTag sums;
  const hn::Rebind<std::uint8_t, WordsTag> bytes;
  const int lanes = static_cast<int>(hn::Lanes(words));
  const int half = lanes / 2;
  const auto centre = hn::Set(words, std::int16_t{128});
  for (int p = 0; p < count; p += lanes) {
    auto total = hn::Zero(words);
    auto square_a = hn::Zero(sums);
    auto square_b = hn::Zero(sums);
    auto dot_a = hn::Zero(sums);
    auto dot_b = hn::Zero(sums);
    auto unused = hn::Zero(sums);
    const std::uint8_t* at = base + p;
    for (int i = 0; i < points; i += 2) {
      const auto v0 = hn::Sub(hn::PromoteTo(words, hn::LoadU(bytes, at + offsets[i])), centre);
      const auto v1 = hn::Sub(hn::PromoteTo(words, hn::LoadU(bytes, at + offsets[i + 1])), centre);
      total = hn::Add(total, hn::Add(v0, v1));
      const auto low = hn::InterleaveLower(words, v0, v1);
      const auto high = hn::InterleaveUpper(words, v0, v1);
      std::int32_t pair = 0;
      std::memcpy(&pair, weights + i, sizeof pair);
      const auto weight = hn::BitCast(words, hn::Set(sums, pair));
      square_a = hn::ReorderWidenMulAccumulate(sums, low, low, square_a, unused);
      square_b = hn::ReorderWidenMulAccumulate(sums, high, high, square_b, unused);
      dot_a = hn::ReorderWidenMulAccumulate(sums, low, weight, dot_a, unused);
      dot_b = hn::ReorderWidenMulAccumulate(sums, high, weight, dot_b, unused);
    }
    // Interleaving works inside 128-bit blocks: put the halves back in order.
    const auto store = [&](auto a, auto b, std::int32_t* out) {
      if (lanes == 16) {
        hn::StoreU(hn::ConcatLowerLower(sums, b, a), sums, out + p);
        hn::StoreU(hn::ConcatUpperUpper(sums, b, a), sums, out + p + half);
      } else {
        hn::StoreU(a, sums, out + p);
        hn::StoreU(b, sums, out + p + half);
      }
    };
    store(square_a, square_b, square);
    store(dot_a, dot_b, dot);
    hn::StoreU(hn::PromoteTo(sums, hn::LowerHalf(total)), sums, sum + p);
    hn::StoreU(hn::PromoteTo(sums, hn::UpperHalf(hn::Half<WordsTag>(), total)), sums, sum + p + half);
  }
}

#else

void correlate_row(const std::uint8_t* base, const std::ptrdiff_t* offsets, const std::int16_t* weights, int points,
                   int count, std::int32_t* sum, std::int32_t* square, std::int32_t* dot) {
  const SumsTag sums;
  const hn::Rebind<std::uint8_t, SumsTag> bytes;
  const int lanes = static_cast<int>(hn::Lanes(sums));
  const auto centre = hn::Set(sums, 128);
  for (int p = 0; p < count; p += lanes) {
    auto s = hn::Zero(sums);
    auto q = hn::Zero(sums);
    auto d = hn::Zero(sums);
    for (int i = 0; i < points; ++i) {
      const auto v = hn::Sub(hn::PromoteTo(sums, hn::LoadU(bytes, base + p + offsets[i])), centre);
      s = hn::Add(s, v);
      q = hn::Add(q, hn::Mul(v, v));
      d = hn::Add(d, hn::Mul(v, hn::Set(sums, weights[i])));
    }
    hn::StoreU(s, sums, sum + p);
    hn::StoreU(q, sums, square + p);
    hn::StoreU(d, sums, dot + p);
  }
}

#endif

#endif  // HWY_TARGET == HWY_SCALAR

const char* target_name() { return hwy::TargetName(HWY_TARGET); }

}  // namespace vsfind::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vsfind::kernels {

HWY_EXPORT(halve_both);
HWY_EXPORT(halve_x);
HWY_EXPORT(halve_y);
HWY_EXPORT(correlate_row);
HWY_EXPORT(target_name);

void halve_both(const std::uint8_t* a, const std::uint8_t* b, std::uint8_t* out, int count) {
  HWY_DYNAMIC_DISPATCH(halve_both)(a, b, out, count);
}
void halve_x(const std::uint8_t* a, std::uint8_t* out, int count) { HWY_DYNAMIC_DISPATCH(halve_x)(a, out, count); }
void halve_y(const std::uint8_t* a, const std::uint8_t* b, std::uint8_t* out, int count) {
  HWY_DYNAMIC_DISPATCH(halve_y)(a, b, out, count);
}
void correlate_row(const std::uint8_t* base, const std::ptrdiff_t* offsets, const std::int16_t* weights, int points,
                   int count, std::int32_t* sum, std::int32_t* square, std::int32_t* dot) {
  HWY_DYNAMIC_DISPATCH(correlate_row)(base, offsets, weights, points, count, sum, square, dot);
}
const char* target_name() { return HWY_DYNAMIC_DISPATCH(target_name)(); }

}  // namespace vsfind::kernels
#endif
