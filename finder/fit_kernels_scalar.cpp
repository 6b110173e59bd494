/// The scalar twins of fit_kernels.h: what the vector code is tested against, and what runs where there is none.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "finder/fit_kernels.h"

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

void residuals(const float* const* columns, const float* beta, int number, const float* value, int count,
               float* residual) {
  for (int i = 0; i < padded(count); ++i) {
    float r = value[i];
    for (int c = 0; c < number; ++c) r -= columns[c][i] * beta[c];
    residual[i] = r;
  }
}

void tukey_weights(const float* residual, const float* inside, float inverse_cut, int count, float* weight) {
  for (int i = 0; i < padded(count); ++i) {
    const float e = residual[i] * inverse_cut;
    const float keep = std::fmax(0.0F, 1.0F - e * e);
    weight[i] = inside[i] * keep * keep;
  }
}

void normal_equations(const float* const* columns, int number, const float* weight, int count, double* lower) {
  for (int r = 0; r < number; ++r) {
    for (int s = 0; s <= r; ++s) {
      double sum = 0.0;
      for (int i = 0; i < padded(count); ++i) {
        sum += static_cast<double>(weight[i] * columns[r][i]) * static_cast<double>(columns[s][i]);
      }
      *lower++ = sum;
    }
  }
}

void correlation_sums(const float* value, const float* target, const float* inside, int count, double sums[6]) {
  for (int k = 0; k < 6; ++k) sums[k] = 0.0;
  for (int i = 0; i < padded(count); ++i) {
    const auto w = static_cast<double>(inside[i]);
    const auto a = static_cast<double>(value[i]);
    const auto b = static_cast<double>(target[i]);
    sums[0] += w;
    sums[1] += w * a;
    sums[2] += w * b;
    sums[3] += w * a * a;
    sums[4] += w * b * b;
    sums[5] += w * a * b;
  }
}

float agreement(const float* value, const float* target, const float* inside, int count, float gain, float offset,
                float inverse_cut) {
  float sum = 0.0F;
  for (int i = 0; i < padded(count); ++i) {
    const float e = (value[i] - gain * target[i] - offset) * inverse_cut;
    sum += inside[i] * std::fmax(0.0F, 1.0F - e * e);
  }
  return sum;
}

float median_below(const float* residual, const float* inside, float limit, int count, float* scratch) {
  float* end = scratch;
  for (int i = 0; i < count; ++i) {
    const float off = std::abs(residual[i]);
    if (inside[i] > 0.0F && off < limit) *end++ = off;
  }
  if (end == scratch) return -1.0F;
  float* const middle = scratch + (end - scratch) / 2;
  std::nth_element(scratch, middle, end);
  return *middle;
}

ViewSums view_sums(const float* residual, const float* target, const float* value, const float* inside, int count,
                   float inverse_cut, float visible_within) {
  ViewSums view;
  for (int i = 0; i < count; ++i) {
    if (inside[i] == 0.0F) continue;
    ++view.inside;
    if (std::abs(residual[i]) <= visible_within) ++view.seen;
    const float e = residual[i] * inverse_cut;
    const float keep = std::fmax(0.0F, 1.0F - e * e);
    const float w = keep * keep;
    const float terms[5] = {w, w * target[i] * target[i], w * residual[i] * residual[i], w * value[i],
                            w * value[i] * value[i]};
    for (int k = 0; k < 5; ++k) view.sums[k] += static_cast<double>(terms[k]);
  }
  return view;
}

}  // namespace vsfind::kernels::scalar
