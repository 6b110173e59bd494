/// The scalar twins of reading_kernels.h: what the vector code is tested against, and what runs where there is none.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "finder/reading_kernels.h"

namespace vsfind::kernels::scalar {

namespace {

/// Whether taps `before` … `after` around the pixel below (u, v) lie inside; false for NaN.
bool taps_inside(const ReadPlane& plane, float u, float v, float before, float after) {
  return u >= plane.left + before && v >= plane.top + before && u < plane.right - after + 1.0F &&
         v < plane.bottom - after + 1.0F;
}

float pixel(const std::byte* at, int bytes) {
  if (bytes == 1) return static_cast<float>(std::to_integer<int>(*at));
  std::uint16_t value = 0;
  std::memcpy(&value, at, sizeof value);
  return static_cast<float>(value);
}

/// Reads `taps` × `taps` pixels, the first `before` pixels left of and above the one below the point.
template <typename Weights>
void read_taps(const ReadPlane& plane, int bytes, int taps, int before, float scale, const float* u, const float* v,
               int count, float* out, float* inside, Weights weights) {
  for (int i = 0; i < padded(count); ++i) {
    out[i] = 0.0F;
    inside[i] = 0.0F;
    if (!taps_inside(plane, u[i], v[i], static_cast<float>(before), static_cast<float>(taps - 1 - before))) continue;
    const auto x = static_cast<int>(std::floor(u[i]));
    const auto y = static_cast<int>(std::floor(v[i]));
    float wx[8];
    float wy[8];
    weights(u[i] - static_cast<float>(x), v[i] - static_cast<float>(y), wx, wy);
    float sum = 0.0F;
    for (int b = 0; b < taps; ++b) {
      const std::byte* line =
          plane.base + (y + b - before) * plane.stride + static_cast<std::ptrdiff_t>(x - before) * bytes;
      float row = 0.0F;
      for (int a = 0; a < taps; ++a) row += wx[a] * pixel(line + static_cast<std::ptrdiff_t>(a) * bytes, bytes);
      sum += wy[b] * row;
    }
    out[i] = scale * sum;
    inside[i] = 1.0F;
  }
}

}  // namespace

void project(const float* x, const float* y, int count, const float m[6], float* u, float* v) {
  for (int i = 0; i < padded(count); ++i) {
    u[i] = m[0] * x[i] + m[1] * y[i] + m[2];
    v[i] = m[3] * x[i] + m[4] * y[i] + m[5];
  }
}

void read_bilinear(const ReadPlane& plane, const float* u, const float* v, int count, float* out, float* inside) {
  read_taps(plane, 1, 2, 0, 1.0F, u, v, count, out, inside, [](float a, float b, float* wx, float* wy) {
    wx[0] = 1.0F - a;
    wx[1] = a;
    wy[0] = 1.0F - b;
    wy[1] = b;
  });
}

void read_smoothed(const ReadPlane& plane, const float* u, const float* v, int count, float* out, float* inside) {
  const auto four = [](float a, float* w) {
    w[0] = 1.0F - a;
    w[1] = 2.0F - a;
    w[2] = 1.0F + a;
    w[3] = a;
  };
  read_taps(plane, 1, 4, 1, 1.0F / 16.0F, u, v, count, out, inside, [&](float a, float b, float* wx, float* wy) {
    four(a, wx);
    four(b, wy);
  });
}

void read_gaussian(const ReadPlane& plane, int pixel_bytes, float kx, float ky, float scale, const float* u,
                   const float* v, int count, float* out, float* inside) {
  const auto eight = [](float a, float k, float* w) {
    float total = 0.0F;
    for (int i = 0; i < 8; ++i) {
      const float d = static_cast<float>(i - 3) - a;
      w[i] = std::exp(k * d * d);
      total += w[i];
    }
    for (int i = 0; i < 8; ++i) w[i] /= total;
  };
  read_taps(plane, pixel_bytes, 8, 3, scale, u, v, count, out, inside, [&](float a, float b, float* wx, float* wy) {
    eight(a, kx, wx);
    eight(b, ky, wy);
  });
}

}  // namespace vsfind::kernels::scalar
