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
using scalar::halve_both;
using scalar::halve_x;
using scalar::halve_y;
using scalar::local_maxima;
using scalar::range_of;
using scalar::stretch;
using scalar::sums_inside;

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

using Dots = hn::Vec<WordsTag>;

/// The sums of one block of positions: of its lower and upper half, as interleaving leaves them.
struct BlockDots {
  Dots low;
  Dots high;

  // Not left to the compiler, which would make it for another instruction set.
  HWY_INLINE BlockDots() : low(hn::Zero(WordsTag())), high(low) {}

  // Two points at a time: their pixels are interleaved, so that one multiply-add of pairs serves both.
  template <class Weights>
  HWY_INLINE void add(const std::uint8_t* first, const std::uint8_t* second, Weights weights) {
    const BytesTag bytes;
    const auto a = hn::LoadU(bytes, first);
    auto b = hn::LoadU(bytes, second);
#if HWY_TARGET <= HWY_SSSE3 && HWY_COMPILER_GCC && HWY_ARCH_X86
    __asm__("" : "+x"(b.raw));  // or else it is loaded twice, and loads are what this waits for
#endif
    low = hn::Add(low, pair_products(hn::InterleaveLower(bytes, a, b), weights));
    high = hn::Add(high, pair_products(hn::InterleaveUpper(bytes, a, b), weights));
  }
};

/// Keeps the better ones of a half block.
HWY_INLINE void keep_better(Dots dots, Polarity polarity, const std::int16_t* factor, std::uint16_t id,
                            std::int16_t* best, std::uint16_t* which) {
  const WordsTag words;
  const hn::RebindToUnsigned<WordsTag> unsigned_words;
  auto scores = hn::MulHigh(dots, hn::LoadU(words, factor));
  if (polarity == Polarity::reversed) scores = hn::Neg(scores);
  if (polarity == Polarity::any) scores = hn::Abs(scores);
  const auto before = hn::LoadU(words, best);
  const auto better = hn::Gt(scores, before);
  hn::StoreU(hn::IfThenElse(better, scores, before), words, best);
  const auto other = hn::LoadU(unsigned_words, which);
  hn::StoreU(hn::IfThenElse(hn::RebindMask(unsigned_words, better), hn::Set(unsigned_words, id), other), unsigned_words,
             which);
}

/// One to three blocks of positions at a time, so that weights and offsets are fetched once for all.
template <int blocks>
void best_dots_of(const std::uint8_t* base, const std::ptrdiff_t* offsets, const std::int8_t* weights, int points,
                  Polarity polarity, const std::int16_t* factor, std::uint16_t id, std::int16_t* best,
                  std::uint16_t* which) {
  const BytesTag bytes;
  const hn::RepartitionToWide<BytesTag> unsigned_words;
  const hn::RebindToSigned<BytesTag> signed_bytes;
  const WordsTag words;
  const auto lanes = static_cast<std::ptrdiff_t>(hn::Lanes(bytes));
  BlockDots a;
  BlockDots b;
  BlockDots c;
  for (int i = 0; i < points; i += 2) {
    std::uint16_t pair = 0;
    std::memcpy(&pair, weights + i, sizeof pair);
    const auto weight = hn::BitCast(signed_bytes, hn::Set(unsigned_words, pair));
    const std::uint8_t* first = base + offsets[i];
    const std::uint8_t* second = base + offsets[i + 1];
    a.add(first, second, weight);
    if constexpr (blocks > 1) b.add(first + lanes, second + lanes, weight);
    if constexpr (blocks > 2) c.add(first + 2 * lanes, second + 2 * lanes, weight);
  }
  // Interleaving works inside 128-bit blocks: put the halves back in order.
  const auto keep = [&](const BlockDots& dots, std::ptrdiff_t from) {
    const auto lower = lanes == 32 ? hn::ConcatLowerLower(words, dots.high, dots.low) : dots.low;
    const auto upper = lanes == 32 ? hn::ConcatUpperUpper(words, dots.high, dots.low) : dots.high;
    keep_better(lower, polarity, factor + from, id, best + from, which + from);
    from += lanes / 2;
    keep_better(upper, polarity, factor + from, id, best + from, which + from);
  };
  keep(a, 0);
  if constexpr (blocks > 1) keep(b, lanes);
  if constexpr (blocks > 2) keep(c, 2 * lanes);
}

void best_dots(const std::uint8_t* base, const std::ptrdiff_t* offsets, const std::int8_t* weights, int points,
               int count, Polarity polarity, const std::int16_t* factor, std::uint16_t id, std::int16_t* best,
               std::uint16_t* which) {
  const int lanes = static_cast<int>(hn::Lanes(BytesTag()));
  // Rounded up to whole dot blocks, which hold one or two of the registers' blocks.
  int blocks = (count + dot_block - 1) / dot_block * (dot_block / lanes);
  while (blocks > 0) {
    const int now = blocks >= 3 && blocks != 4 ? 3 : blocks >= 2 ? 2 : 1;
    const auto run = now == 3 ? best_dots_of<3> : now == 2 ? best_dots_of<2> : best_dots_of<1>;
    run(base, offsets, weights, points, polarity, factor, id, best, which);
    const int done = now * lanes;
    base += done;
    factor += done;
    best += done;
    which += done;
    blocks -= now;
  }
}

int local_maxima(const std::int16_t* above, const std::int16_t* row, const std::int16_t* below, int count,
                 std::int16_t least, std::uint16_t* columns) {
  const WordsTag words;
  const int lanes = static_cast<int>(hn::Lanes(words));
  const auto floor = hn::Set(words, least);
  int found = 0;
  std::ptrdiff_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    const auto at = [&](const std::int16_t* line) { return hn::LoadU(words, line + i); };
    const auto score = at(row);
    // No maximum but those above both sides: what may equal it, and what may not.
    const auto up_to = hn::Max(hn::Max(at(above - 1), at(above)), hn::Max(at(above + 1), at(row - 1)));
    const auto below_it = hn::Max(hn::Max(at(below - 1), at(below)), hn::Max(at(below + 1), at(row + 1)));
    const auto is = hn::AndNot(hn::Gt(hn::Max(floor, up_to), score), hn::Gt(score, below_it));
    if (hn::AllFalse(words, is)) continue;
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(words, is, bits);
    for (int k = 0; k < lanes; ++k) {
      if ((bits[k / 8] >> (k % 8) & 1) != 0) columns[found++] = static_cast<std::uint16_t>(i + k);
    }
  }
  if (i < count) {
    const int more =
        scalar::local_maxima(above + i, row + i, below + i, static_cast<int>(count - i), least, columns + found);
    for (int k = 0; k < more; ++k) columns[found + k] = static_cast<std::uint16_t>(columns[found + k] + i);
    found += more;
  }
  return found;
}

SparseSums sums_inside(const std::uint8_t* base, const SparsePoints& points, int least_u, int most_u, int least_v,
                       int most_v) {
  const WordsTag words;
  const hn::RepartitionToWide<WordsTag> ints;
  const hn::Rebind<std::uint8_t, WordsTag> bytes;
  const int lanes = static_cast<int>(hn::Lanes(words));
  alignas(32) std::uint8_t pixels[most_sum_points + sum_block];
  const int padded = (points.count + sum_block - 1) / sum_block * sum_block;
  for (int i = 0; i < points.count; ++i) pixels[i] = base[points.offsets[i]];
  for (int i = points.count; i < padded; ++i) pixels[i] = 0;
  // Limits that hold for all points, where they do not fit a word: no offset does.
  const auto limit = [&](int value) {
    return hn::Set(words, static_cast<std::int16_t>(value < -32768 ? -32768 : value > 32767 ? 32767 : value));
  };
  const auto low_u = limit(least_u);
  const auto high_u = limit(most_u);
  const auto low_v = limit(least_v);
  const auto high_v = limit(most_v);
  const auto one = hn::Set(words, std::int16_t{1});
  auto counts = hn::Zero(words);
  auto sum = counts;
  auto weights = hn::Zero(ints);
  auto squares = weights;
  auto dots = weights;
  auto weight_squares = weights;
  auto more_weights = weights;
  auto more_squares = weights;
  auto more_dots = weights;
  auto more_weight_squares = weights;
  for (int i = 0; i < padded; i += lanes) {
    const auto u = hn::LoadU(words, points.du + i);
    const auto v = hn::LoadU(words, points.dv + i);
    const auto outside =
        hn::Or(hn::Or(hn::Gt(low_u, u), hn::Gt(u, high_u)), hn::Or(hn::Gt(low_v, v), hn::Gt(v, high_v)));
    const auto p = hn::IfThenZeroElse(outside, hn::PromoteTo(words, hn::LoadU(bytes, pixels + i)));
    const auto w = hn::IfThenZeroElse(outside, hn::LoadU(words, points.weights + i));
    auto in = hn::IfThenZeroElse(outside, one);
    if (i + lanes > points.count)
      in = hn::IfThenElseZero(hn::FirstN(words, points.count > i ? static_cast<std::size_t>(points.count - i) : 0), in);
    counts = hn::Add(counts, in);
    sum = hn::Add(sum, p);
    squares = hn::ReorderWidenMulAccumulate(ints, p, p, squares, more_squares);
    dots = hn::ReorderWidenMulAccumulate(ints, p, w, dots, more_dots);
    weights = hn::ReorderWidenMulAccumulate(ints, w, one, weights, more_weights);
    weight_squares = hn::ReorderWidenMulAccumulate(ints, w, w, weight_squares, more_weight_squares);
  }
  const auto total = [&](auto a, auto b) { return hn::GetLane(hn::SumOfLanes(ints, hn::Add(a, b))); };
  const auto total_of_words = [&](auto a) {
    auto more = hn::Zero(ints);
    const auto wide = hn::ReorderWidenMulAccumulate(ints, a, one, hn::Zero(ints), more);
    return total(wide, more);
  };
  SparseSums sums;
  sums.count = total_of_words(counts);
  sums.pixels = total_of_words(sum);
  sums.squares = total(squares, more_squares);
  sums.dots = total(dots, more_dots);
  sums.weights = total(weights, more_weights);
  sums.weight_squares = total(weight_squares, more_weight_squares);
  return sums;
}

void range_of(const std::uint8_t* from, std::ptrdiff_t stride, int width, int height, std::uint8_t& least,
              std::uint8_t& most) {
  const BytesTag bytes;
  const int lanes = static_cast<int>(hn::Lanes(bytes));
  if (width < lanes) {
    scalar::range_of(from, stride, width, height, least, most);
    return;
  }
  auto low = hn::LoadU(bytes, from);
  auto high = low;
  for (int y = 0; y < height; ++y, from += stride) {
    // The last register overlaps the one before it.
    for (int x = 0; x < width; x += lanes) {
      const auto v = hn::LoadU(bytes, from + (x + lanes <= width ? x : width - lanes));
      low = hn::Min(low, v);
      high = hn::Max(high, v);
    }
  }
  alignas(32) std::uint8_t all[2 * dot_block];
  std::uint8_t ignored = 0;
  hn::Store(low, bytes, all);
  hn::Store(high, bytes, all + dot_block);
  scalar::range_of(all, lanes, lanes, 1, least, ignored);
  scalar::range_of(all + dot_block, lanes, lanes, 1, ignored, most);
}

void stretch(const std::uint8_t* from, int count, std::uint8_t least, std::uint16_t factor, std::uint8_t* to) {
  const hn::RebindToUnsigned<WordsTag> words;
  const hn::Rebind<std::uint8_t, decltype(words)> bytes;
  const int lanes = static_cast<int>(hn::Lanes(words));
  const auto low = hn::Set(words, std::uint16_t{least});
  const auto by = hn::Set(words, factor);
  std::ptrdiff_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    const auto v = hn::Sub(hn::PromoteTo(words, hn::LoadU(bytes, from + i)), low);
    const auto stretched = hn::ShiftRight<8>(hn::Mul(v, by));
    hn::StoreU(hn::DemoteTo(bytes, hn::BitCast(WordsTag(), stretched)), bytes, to + i);
  }
  if (i < count) scalar::stretch(from + i, static_cast<int>(count - i), least, factor, to + i);
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
HWY_EXPORT(local_maxima);
HWY_EXPORT(sums_inside);
HWY_EXPORT(range_of);
HWY_EXPORT(stretch);
HWY_EXPORT(target_name);

void halve_both(const std::uint8_t* a, const std::uint8_t* b, std::uint8_t* out, int count) {
  HWY_DYNAMIC_DISPATCH(halve_both)(a, b, out, count);
}
void halve_x(const std::uint8_t* a, std::uint8_t* out, int count) { HWY_DYNAMIC_DISPATCH(halve_x)(a, out, count); }
void halve_y(const std::uint8_t* a, const std::uint8_t* b, std::uint8_t* out, int count) {
  HWY_DYNAMIC_DISPATCH(halve_y)(a, b, out, count);
}
void best_dots(const std::uint8_t* base, const std::ptrdiff_t* offsets, const std::int8_t* weights, int points,
               int count, Polarity polarity, const std::int16_t* factor, std::uint16_t id, std::int16_t* best,
               std::uint16_t* which) {
  HWY_DYNAMIC_DISPATCH(best_dots)(base, offsets, weights, points, count, polarity, factor, id, best, which);
}
int local_maxima(const std::int16_t* above, const std::int16_t* row, const std::int16_t* below, int count,
                 std::int16_t least, std::uint16_t* columns) {
  return HWY_DYNAMIC_DISPATCH(local_maxima)(above, row, below, count, least, columns);
}
SparseSums sums_inside(const std::uint8_t* base, const SparsePoints& points, int least_u, int most_u, int least_v,
                       int most_v) {
  return HWY_DYNAMIC_DISPATCH(sums_inside)(base, points, least_u, most_u, least_v, most_v);
}
void range_of(const std::uint8_t* from, std::ptrdiff_t stride, int width, int height, std::uint8_t& least,
              std::uint8_t& most) {
  HWY_DYNAMIC_DISPATCH(range_of)(from, stride, width, height, least, most);
}
void stretch(const std::uint8_t* from, int count, std::uint8_t least, std::uint16_t factor, std::uint8_t* to) {
  HWY_DYNAMIC_DISPATCH(stretch)(from, count, least, factor, to);
}
const char* target_name() { return HWY_DYNAMIC_DISPATCH(target_name)(); }

}  // namespace vsfind::kernels
#endif
