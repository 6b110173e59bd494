#include "finder/pattern_spline.h"

#include <algorithm>
#include <cmath>

namespace vsfind {

namespace {

/// Coefficients of the cubic B-spline through `count` values at the given stride, in place; the ends are mirrored.
void prefilter(float* values, int count, std::ptrdiff_t stride) {
  if (count < 2) return;
  const double pole = std::sqrt(3.0) - 2.0;
  const auto at = [&](int i) -> float& { return values[i * stride]; };
  // The causal filter starts from what the mirrored signal would have left; 16 terms are below a float's rounding.
  double sum = static_cast<double>(at(0));
  double power = pole;
  for (int i = 1; i < std::min(count, 16); ++i, power *= pole) sum += power * static_cast<double>(at(i));
  double before = sum;
  at(0) = static_cast<float>(before);
  for (int i = 1; i < count; ++i) {
    before = static_cast<double>(at(i)) + pole * before;
    at(i) = static_cast<float>(before);
  }
  double after = pole / (pole * pole - 1.0) * (before + pole * static_cast<double>(at(count - 2)));
  at(count - 1) = static_cast<float>(6.0 * after);
  for (int i = count - 2; i >= 0; --i) {
    after = pole * (after - static_cast<double>(at(i)));
    at(i) = static_cast<float>(6.0 * after);
  }
}

/// Weights of the four coefficients around a fraction, with their first and second derivatives.
struct Weights {
  double value[4];
  double slope[4];
  double bend[4];
  explicit Weights(double t) {
    const double r = 1.0 - t;
    value[0] = r * r * r / 6.0;
    value[1] = (4.0 - 6.0 * t * t + 3.0 * t * t * t) / 6.0;
    value[2] = (4.0 - 6.0 * r * r + 3.0 * r * r * r) / 6.0;
    value[3] = t * t * t / 6.0;
    slope[0] = -0.5 * r * r;
    slope[1] = 1.5 * t * t - 2.0 * t;
    slope[2] = 2.0 * r - 1.5 * r * r;
    slope[3] = 0.5 * t * t;
    bend[0] = r;
    bend[1] = 3.0 * t - 2.0;
    bend[2] = 3.0 * r - 2.0;
    bend[3] = t;
  }
};

}  // namespace

PatternSpline::PatternSpline(const PatternImage& image)
    : width_(image.width),
      height_(image.height),
      origin_x_(image.origin_x),
      origin_y_(image.origin_y),
      mask_(image.mask) {
  constexpr float scale = 1.0F / 256.0F;
  coefficients_.reserve(image.grey.size());
  for (const std::uint16_t grey : image.grey) coefficients_.push_back(scale * static_cast<float>(grey));
  for (int y = 0; y < height_; ++y)
    prefilter(coefficients_.data() + static_cast<std::ptrdiff_t>(y) * width_, width_, 1);
  for (int x = 0; x < width_; ++x) prefilter(coefficients_.data() + x, height_, width_);
}

bool PatternSpline::read(double x, double y, PatternPoint& point) const {
  const double u = x + origin_x_;
  const double v = y + origin_y_;
  if (!(u >= 1.0 && v >= 1.0 && u < width_ - 2.0 && v < height_ - 2.0)) return false;
  const int left = static_cast<int>(u);
  const int top = static_cast<int>(v);
  const std::ptrdiff_t nearest = std::lround(v) * static_cast<std::ptrdiff_t>(width_) + std::lround(u);
  constexpr std::uint8_t in_pattern = 255;
  if (mask_[static_cast<std::size_t>(nearest)] != in_pattern) return false;
  const Weights wx(u - left);
  const Weights wy(v - top);
  double value = 0.0;
  double gx = 0.0;
  double gy = 0.0;
  double xx = 0.0;
  double yy = 0.0;
  double xy = 0.0;
  for (int j = 0; j < 4; ++j) {
    const float* row = coefficients_.data() + static_cast<std::ptrdiff_t>(top - 1 + j) * width_ + (left - 1);
    double line = 0.0;
    double slope = 0.0;
    double bend = 0.0;
    for (int i = 0; i < 4; ++i) {
      const auto c = static_cast<double>(row[i]);
      line += wx.value[i] * c;
      slope += wx.slope[i] * c;
      bend += wx.bend[i] * c;
    }
    value += wy.value[j] * line;
    gx += wy.value[j] * slope;
    gy += wy.slope[j] * line;
    xx += wy.value[j] * bend;
    yy += wy.bend[j] * line;
    xy += wy.slope[j] * slope;
  }
  point.x = x;
  point.y = y;
  point.value = static_cast<float>(value);
  point.gradient_x = static_cast<float>(gx);
  point.gradient_y = static_cast<float>(gy);
  point.laplacian = static_cast<float>(xx + yy);
  point.stretch = static_cast<float>(xx - yy);
  point.shear = static_cast<float>(2.0 * xy);
  return true;
}

}  // namespace vsfind
