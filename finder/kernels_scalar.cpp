#include <algorithm>

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
               int count, Polarity polarity, const std::int16_t* factor, std::uint16_t id, std::int16_t* best,
               std::uint16_t* which) {
  const int all = (count + dot_block - 1) / dot_block * dot_block;
  for (int p = 0; p < all; ++p) {
    int dot = 0;
    for (int i = 0; i < points; ++i) dot += weights[i] * base[p + offsets[i]];
    keep_better((dot * factor[p]) >> 16, polarity, id, best[p], which[p]);
  }
}

int local_maxima(const std::int16_t* above, const std::int16_t* row, const std::int16_t* below, int count,
                 std::int16_t least, std::uint16_t* columns) {
  int found = 0;
  for (int i = 0; i < count; ++i) {
    const std::int16_t score = row[i];
    if (score < least || row[i - 1] > score || row[i + 1] >= score) continue;
    bool highest = true;
    for (int k = -1; k <= 1; ++k) highest = highest && above[i + k] <= score && below[i + k] < score;
    if (highest) columns[found++] = static_cast<std::uint16_t>(i);
  }
  return found;
}

SparseSums sums_inside(const std::uint8_t* base, const SparsePoints& points, int least_u, int most_u, int least_v,
                       int most_v) {
  SparseSums sums;
  for (int i = 0; i < points.count; ++i) {
    if (points.du[i] < least_u || points.du[i] > most_u || points.dv[i] < least_v || points.dv[i] > most_v) continue;
    const int pixel = base[points.offsets[i]];
    const int weight = points.weights[i];
    ++sums.count;
    sums.pixels += pixel;
    sums.squares += pixel * pixel;
    sums.dots += pixel * weight;
    sums.weights += weight;
    sums.weight_squares += weight * weight;
  }
  return sums;
}

void range_of(const std::uint8_t* from, std::ptrdiff_t stride, int width, int height, std::uint8_t& least,
              std::uint8_t& most) {
  least = most = *from;
  for (int y = 0; y < height; ++y, from += stride) {
    const auto [low, high] = std::minmax_element(from, from + width);
    least = std::min(least, *low);
    most = std::max(most, *high);
  }
}

void stretch(const std::uint8_t* from, int count, std::uint8_t least, std::uint16_t factor, std::uint8_t* to) {
  for (int i = 0; i < count; ++i) to[i] = static_cast<std::uint8_t>((from[i] - least) * factor >> 8);
}

}  // namespace vsfind::kernels::scalar
