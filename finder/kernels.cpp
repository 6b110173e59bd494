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

using scalar::best_dots;
using scalar::best_dots_inside;
using scalar::halve_both;
using scalar::halve_x;
using scalar::halve_y;

#else

namespace hn = hwy::HWY_NAMESPACE;

// 256 bits at most: wider registers gain nothing on rows this short.
using BytesTag = hn::CappedTag<std::uint8_t, 32>;
using WordsTag = hn::CappedTag<std::int16_t, 16>;

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

/// Neighbouring products summed: out[i] = a[2i]·b[2i] + a[2i+1]·b[2i+1]. Pixels of 7 bits: no sum leaves 16 bits.
template <class Bytes, class SignedBytes>
auto pair_products(Bytes pixels, SignedBytes weights) {
#if HWY_TARGET == HWY_AVX2 || HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL
  return hn::Vec256<std::int16_t>{_mm256_maddubs_epi16(pixels.raw, weights.raw)};
#elif HWY_TARGET == HWY_SSE4 || HWY_TARGET == HWY_SSSE3
  return hn::Vec128<std::int16_t>{_mm_maddubs_epi16(pixels.raw, weights.raw)};
#else
  const WordsTag words;
  const auto p = hn::BitCast(words, pixels);
  const auto w = hn::BitCast(words, weights);
  const auto even = hn::Mul(hn::And(p, hn::Set(words, std::int16_t{0xFF})), hn::ShiftRight<8>(hn::ShiftLeft<8>(w)));
  return hn::Add(even, hn::Mul(hn::ShiftRight<8>(p), hn::ShiftRight<8>(w)));
#endif
}

/// best_dots() with or without what points outside the picture want.
template <bool inside>
void best_dots_of(const std::uint8_t* base, const std::ptrdiff_t* offsets, const std::int8_t* weights, int points,
                  int count, Polarity polarity, const std::int16_t* factor, const std::int16_t* shift, std::uint16_t id,
                  std::int16_t* best, std::uint16_t* which) {
  const BytesTag bytes;
  const hn::RepartitionToWide<BytesTag> unsigned_words;
  const hn::RebindToSigned<BytesTag> signed_bytes;
  const hn::RebindToSigned<decltype(unsigned_words)> words;
  const int lanes = static_cast<int>(hn::Lanes(bytes));
  const auto ids = hn::Set(unsigned_words, id);
  const auto ones = hn::Set(signed_bytes, std::int8_t{1});
  for (int p = 0; p < count; p += lanes) {
    auto low = hn::Zero(words);
    auto high = hn::Zero(words);
    auto low_sum = hn::Zero(words);
    auto high_sum = hn::Zero(words);
    const std::uint8_t* at = base + p;
    // Two points at a time: their pixels are interleaved, so that one multiply-add of pairs serves both.
    for (int i = 0; i < points; i += 2) {
      const auto v0 = hn::LoadU(bytes, at + offsets[i]);
      const auto v1 = hn::LoadU(bytes, at + offsets[i + 1]);
      std::uint16_t pair = 0;
      std::memcpy(&pair, weights + i, sizeof pair);
      const auto weight = hn::BitCast(signed_bytes, hn::Set(unsigned_words, pair));
      const auto first = hn::InterleaveLower(bytes, v0, v1);
      const auto second = hn::InterleaveUpper(bytes, v0, v1);
      low = hn::Add(low, pair_products(first, weight));
      high = hn::Add(high, pair_products(second, weight));
      if constexpr (inside) {
        low_sum = hn::Add(low_sum, pair_products(first, ones));
        high_sum = hn::Add(high_sum, pair_products(second, ones));
      }
    }
    // Interleaving works inside 128-bit blocks: put the halves back in order.
    const auto lower = [&](auto a, auto b) { return lanes == 32 ? hn::ConcatLowerLower(words, b, a) : a; };
    const auto upper = [&](auto a, auto b) { return lanes == 32 ? hn::ConcatUpperUpper(words, b, a) : b; };
    const auto keep = [&](auto dots, auto sums, int from) {
      auto scores = hn::ShiftRight<2>(dots);
      if constexpr (inside) {
        scores = hn::Sub(hn::MulHigh(dots, hn::LoadU(words, factor + from)),
                         hn::MulHigh(hn::ShiftLeft<2>(sums), hn::LoadU(words, shift + from)));
      }
      if (polarity == Polarity::reversed) scores = hn::Neg(scores);
      if (polarity == Polarity::any) scores = hn::Abs(scores);
      const auto before = hn::LoadU(words, best + from);
      const auto better = hn::Gt(scores, before);
      hn::StoreU(hn::IfThenElse(better, scores, before), words, best + from);
      const auto other = hn::LoadU(unsigned_words, which + from);
      hn::StoreU(hn::IfThenElse(hn::RebindMask(unsigned_words, better), ids, other), unsigned_words, which + from);
    };
    keep(lower(low, high), lower(low_sum, high_sum), p);
    keep(upper(low, high), upper(low_sum, high_sum), p + lanes / 2);
  }
}

void best_dots(const std::uint8_t* base, const std::ptrdiff_t* offsets, const std::int8_t* weights, int points,
               int count, Polarity polarity, std::uint16_t id, std::int16_t* best, std::uint16_t* which) {
  best_dots_of<false>(base, offsets, weights, points, count, polarity, nullptr, nullptr, id, best, which);
}

void best_dots_inside(const std::uint8_t* base, const std::ptrdiff_t* offsets, const std::int8_t* weights, int points,
                      int count, Polarity polarity, const std::int16_t* factor, const std::int16_t* shift,
                      std::uint16_t id, std::int16_t* best, std::uint16_t* which) {
  best_dots_of<true>(base, offsets, weights, points, count, polarity, factor, shift, id, best, which);
}

#endif  // HWY_TARGET == HWY_SCALAR

const char* target_name() { return hwy::TargetName(HWY_TARGET); }

}  // namespace vsfind::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vsfind::kernels {

HWY_EXPORT(halve_both);
HWY_EXPORT(halve_x);
HWY_EXPORT(halve_y);
HWY_EXPORT(best_dots);
HWY_EXPORT(best_dots_inside);
HWY_EXPORT(target_name);

void halve_both(const std::uint8_t* a, const std::uint8_t* b, std::uint8_t* out, int count) {
  HWY_DYNAMIC_DISPATCH(halve_both)(a, b, out, count);
}
void halve_x(const std::uint8_t* a, std::uint8_t* out, int count) { HWY_DYNAMIC_DISPATCH(halve_x)(a, out, count); }
void halve_y(const std::uint8_t* a, const std::uint8_t* b, std::uint8_t* out, int count) {
  HWY_DYNAMIC_DISPATCH(halve_y)(a, b, out, count);
}
void best_dots(const std::uint8_t* base, const std::ptrdiff_t* offsets, const std::int8_t* weights, int points,
               int count, Polarity polarity, std::uint16_t id, std::int16_t* best, std::uint16_t* which) {
  HWY_DYNAMIC_DISPATCH(best_dots)(base, offsets, weights, points, count, polarity, id, best, which);
}
void best_dots_inside(const std::uint8_t* base, const std::ptrdiff_t* offsets, const std::int8_t* weights, int points,
                      int count, Polarity polarity, const std::int16_t* factor, const std::int16_t* shift,
                      std::uint16_t id, std::int16_t* best, std::uint16_t* which) {
  HWY_DYNAMIC_DISPATCH(best_dots_inside)
  (base, offsets, weights, points, count, polarity, factor, shift, id, best, which);
}
const char* target_name() { return HWY_DYNAMIC_DISPATCH(target_name)(); }

}  // namespace vsfind::kernels
#endif
