#include "finder/kernels.h"

namespace vsfind::kernels::scalar {

void halve_both(const std::uint8_t* a, const std::uint8_t* b, std::uint8_t* out, int count) {
  for (int i = 0; i < count; ++i) {
    const std::ptrdiff_t j = 2 * static_cast<std::ptrdiff_t>(i);
    out[i] = static_cast<std::uint8_t>((a[j] + a[j + 1] + b[j] + b[j + 1] + 2) >> 2);
  }
}

void halve_x(const std::uint8_t* a, std::uint8_t* out, int count) {
  for (int i = 0; i < count; ++i) {
    const std::ptrdiff_t j = 2 * static_cast<std::ptrdiff_t>(i);
    out[i] = static_cast<std::uint8_t>((a[j] + a[j + 1] + 1) >> 1);
  }
}

void halve_y(const std::uint8_t* a, const std::uint8_t* b, std::uint8_t* out, int count) {
  for (int i = 0; i < count; ++i) out[i] = static_cast<std::uint8_t>((a[i] + b[i] + 1) >> 1);
}

namespace {

void keep_better(int score, Polarity polarity, std::uint16_t id, std::int16_t& best, std::uint16_t& which) {
  if (polarity == Polarity::reversed || (polarity == Polarity::any && score < 0)) score = -score;
  if (score <= best) return;
  best = static_cast<std::int16_t>(score);
  which = id;
}

}  // namespace

void best_dots(const std::uint8_t* base, const std::ptrdiff_t* offsets, const std::int8_t* weights, int points,
               int count, Polarity polarity, std::uint16_t id, std::int16_t* best, std::uint16_t* which) {
  const int all = (count + dot_block - 1) / dot_block * dot_block;
  for (int p = 0; p < all; ++p) {
    int dot = 0;
    for (int i = 0; i < points; ++i) dot += weights[i] * base[p + offsets[i]];
    keep_better(dot >> 2, polarity, id, best[p], which[p]);
  }
}

void best_dots_inside(const std::uint8_t* base, const std::ptrdiff_t* offsets, const std::int8_t* weights, int points,
                      int count, Polarity polarity, const std::int16_t* factor, const std::int16_t* shift,
                      std::uint16_t id, std::int16_t* best, std::uint16_t* which) {
  const int all = (count + dot_block - 1) / dot_block * dot_block;
  for (int p = 0; p < all; ++p) {
    int dot = 0;
    int sum = 0;
    for (int i = 0; i < points; ++i) {
      dot += weights[i] * base[p + offsets[i]];
      sum += base[p + offsets[i]];
    }
    keep_better(((dot * factor[p]) >> 16) - ((4 * sum * shift[p]) >> 16), polarity, id, best[p], which[p]);
  }
}

}  // namespace vsfind::kernels::scalar
