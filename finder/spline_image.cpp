#include "finder/spline_image.h"

#include <cmath>

namespace vsfind {

namespace {

/// From values to coefficients along one line, in place: the filter's two passes, mirrored at the ends.
void prefilter(float* line, int count, int stride) {
  if (count < 2) return;
  const double pole = std::sqrt(3.0) - 2.0;
  const auto at = [&](int i) -> float& { return line[static_cast<std::ptrdiff_t>(i) * stride]; };
  constexpr double gain = 6.0;
  double sum = 0.0;
  double power = 1.0;
  constexpr int horizon = 24;  // pole^24 < 1e-13
  for (int i = 0; i < count && i < horizon; ++i) {
    sum += power * static_cast<double>(at(i));
    power *= pole;
  }
  double last = gain * sum;
  at(0) = static_cast<float>(last);
  for (int i = 1; i < count; ++i) {
    last = gain * static_cast<double>(at(i)) + pole * last;
    at(i) = static_cast<float>(last);
  }
  last = pole / (pole * pole - 1.0) * (last + pole * static_cast<double>(at(count - 2)));
  at(count - 1) = static_cast<float>(last);
  for (int i = count - 2; i >= 0; --i) {
    last = pole * (last - static_cast<double>(at(i)));
    at(i) = static_cast<float>(last);
  }
}

struct Weights {
  double w[4];
  double d[4];
  double dd[4];
};

Weights weights(double t) {
  const double s = 1.0 - t;
  return {{s * s * s / 6.0, 2.0 / 3.0 - t * t * (2.0 - t) / 2.0, 2.0 / 3.0 - s * s * (2.0 - s) / 2.0, t * t * t / 6.0},
          {-s * s / 2.0, 1.5 * t * t - 2.0 * t, 2.0 * s - 1.5 * s * s, t * t / 2.0},
          {s, 3.0 * t - 2.0, 3.0 * s - 2.0, t}};
}

}  // namespace

SplineImage::SplineImage(std::vector<float> values, int width, int height)
    : coefficients_(std::move(values)), width_(width), height_(height) {
  for (int y = 0; y < height; ++y) prefilter(coefficients_.data() + static_cast<std::ptrdiff_t>(y) * width, width, 1);
  for (int x = 0; x < width; ++x) prefilter(coefficients_.data() + x, height, width);
}

bool SplineImage::sample(double x, double y, Sample& out) const {
  if (!(x >= 1.0 && y >= 1.0 && x < width_ - 2.0 && y < height_ - 2.0)) return false;
  const int column = static_cast<int>(x);
  const int row = static_cast<int>(y);
  const Weights wx = weights(x - column);
  const Weights wy = weights(y - row);
  out = {};
  for (int j = 0; j < 4; ++j) {
    const float* c = coefficients_.data() + static_cast<std::ptrdiff_t>(row - 1 + j) * width_ + (column - 1);
    double value = 0.0;
    double slope = 0.0;
    double bend = 0.0;
    for (int i = 0; i < 4; ++i) {
      const auto k = static_cast<double>(c[i]);
      value += wx.w[i] * k;
      slope += wx.d[i] * k;
      bend += wx.dd[i] * k;
    }
    out.value += wy.w[j] * value;
    out.gradient_x += wy.w[j] * slope;
    out.gradient_y += wy.d[j] * value;
    out.laplacian += wy.w[j] * bend + wy.dd[j] * value;
  }
  return true;
}

}  // namespace vsfind
