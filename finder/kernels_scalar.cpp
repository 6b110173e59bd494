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

void correlate_row(const std::uint8_t* base, const std::ptrdiff_t* offsets, const std::int16_t* weights, int points,
                   int count, std::int32_t* sum, std::int32_t* square, std::int32_t* dot) {
  for (int p = 0; p < count; ++p) {
    std::int32_t s = 0;
    std::int32_t q = 0;
    std::int32_t d = 0;
    for (int i = 0; i < points; ++i) {
      const std::int32_t v = static_cast<std::int32_t>(base[p + offsets[i]]) - 128;
      s += v;
      q += v * v;
      d += weights[i] * v;
    }
    sum[p] = s;
    square[p] = q;
    dot[p] = d;
  }
}

}  // namespace vsfind::kernels::scalar
