/// The scalar twins of fit_kernels.h: what the vector code is tested against, and what runs where there is none.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "finder/fit_kernels.h"

namespace vsfind::kernels::scalar {

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
