#include "finder/sampling.h"

#include <cmath>

#include "finder/reading_kernels.h"

namespace vsfind {

namespace {

kernels::ReadPlane plane_around(const std::byte* data, std::ptrdiff_t stride, int width, int height, int pixel_bytes,
                                const Places& places) {
  kernels::ReadPlane plane;
  plane.base = data + places.base_y * stride + static_cast<std::ptrdiff_t>(places.base_x) * pixel_bytes;
  plane.stride = stride;
  plane.left = static_cast<float>(-places.base_x);
  plane.top = static_cast<float>(-places.base_y);
  plane.right = static_cast<float>(width - 1 - places.base_x);
  plane.bottom = static_cast<float>(height - 1 - places.base_y);
  return plane;
}

kernels::ReadPlane plane_around(const Level& level, const Places& places) {
  return plane_around(reinterpret_cast<const std::byte*>(level.data), level.stride, level.width, level.height, 1,
                      places);
}

/// From the pixels of a picture to 0 … 255.
double scale_of(const ImageView& image) {
  return 255.0 / (image.bits > 8 ? 255.0 * std::ldexp(1.0, image.bits - 8) : 255.0);
}

}  // namespace

void BilinearReader::read(const Places& places, int count, float* out, float* inside) const {
  kernels::read_bilinear(plane_around(level_, places), places.u.data(), places.v.data(), count, out, inside);
}

void SmoothingReader::read(const Places& places, int count, float* out, float* inside) const {
  kernels::read_smoothed(plane_around(level_, places), places.u.data(), places.v.data(), count, out, inside);
}

void GaussianReader::read(const Places& places, int count, float* out, float* inside) const {
  const int bytes = image_.bits > 8 ? 2 : 1;
  kernels::read_gaussian(plane_around(image_.data, image_.stride, image_.width, image_.height, bytes, places), bytes,
                         static_cast<float>(-0.5 / (sigma_x_ * sigma_x_)),
                         static_cast<float>(-0.5 / (sigma_y_ * sigma_y_)), static_cast<float>(scale_of(image_)),
                         places.u.data(), places.v.data(), count, out, inside);
}

void BilinearReader::read(const double* u, const double* v, int count, double* out, double* inside) const {
  const double last_u = level_.width - 1;
  const double last_v = level_.height - 1;
  for (int i = 0; i < count; ++i) {
    // The negation catches NaN as well.
    if (!(u[i] >= 0.0 && v[i] >= 0.0 && u[i] < last_u && v[i] < last_v)) {
      out[i] = 0.0;
      inside[i] = 0.0;
      continue;
    }
    const int x = static_cast<int>(u[i]);
    const int y = static_cast<int>(v[i]);
    const double a = u[i] - x;
    const double b = v[i] - y;
    const std::uint8_t* p = level_.row(y) + x;
    const std::uint8_t* q = p + level_.stride;
    const double top = p[0] + a * (p[1] - p[0]);
    const double bottom = q[0] + a * (q[1] - q[0]);
    out[i] = top + b * (bottom - top);
    inside[i] = 1.0;
  }
}

namespace {

/// Normalized weights of the taps −3 … 4 around the pixel below `fraction` (0 … 1).
void gaussian_weights(double fraction, double sigma, double* weights) {
  const double k = -0.5 / (sigma * sigma);
  double total = 0.0;
  for (int i = 0; i < GaussianReader::taps; ++i) {
    const double d = i - 3 - fraction;
    weights[i] = std::exp(k * d * d);
    total += weights[i];
  }
  for (int i = 0; i < GaussianReader::taps; ++i) weights[i] /= total;
}

bool taps_inside(const ImageView& image, double u, double v) {
  return u >= 3.0 && v >= 3.0 && u < image.width - 4.0 && v < image.height - 4.0;
}

template <typename Pixel>
double weighted_sum(const ImageView& image, int x, int y, const double* wx, const double* wy) {
  double sum = 0.0;
  for (int j = 0; j < GaussianReader::taps; ++j) {
    const Pixel* p = reinterpret_cast<const Pixel*>(image.data + (y - 3 + j) * image.stride) + (x - 3);
    double line = 0.0;
    for (int i = 0; i < GaussianReader::taps; ++i) line += wx[i] * p[i];
    sum += wy[j] * line;
  }
  return sum;
}

double weighted_sum(const ImageView& image, int x, int y, const double* wx, const double* wy) {
  return image.bits > 8 ? weighted_sum<std::uint16_t>(image, x, y, wx, wy)
                        : weighted_sum<std::uint8_t>(image, x, y, wx, wy);
}

}  // namespace

void GaussianReader::read(const double* u, const double* v, int count, double* out, double* inside) const {
  const double scale = scale_of(image_);
  double wx[taps];
  double wy[taps];
  for (int i = 0; i < count; ++i) {
    if (!taps_inside(image_, u[i], v[i])) {
      out[i] = 0.0;
      inside[i] = 0.0;
      continue;
    }
    const int x = static_cast<int>(u[i]);
    const int y = static_cast<int>(v[i]);
    gaussian_weights(u[i] - x, sigma_x_, wx);
    gaussian_weights(v[i] - y, sigma_y_, wy);
    out[i] = scale * weighted_sum(image_, x, y, wx, wy);
    inside[i] = 1.0;
  }
}

bool GaussianReader::read_with_derivatives(double u, double v, double out[4]) const {
  // Central differences of the smoothed picture itself: exactly the derivative of what read() returns.
  constexpr double step = 0.25;
  if (!taps_inside(image_, u - step, v - step) || !taps_inside(image_, u + step, v + step)) return false;
  const double us[5] = {u, u - step, u + step, u, u};
  const double vs[5] = {v, v, v, v - step, v + step};
  double values[5];
  double inside[5];
  read(us, vs, 5, values, inside);
  out[0] = values[0];
  out[1] = (values[2] - values[1]) / (2.0 * step);
  out[2] = (values[4] - values[3]) / (2.0 * step);
  out[3] = (values[1] + values[2] + values[3] + values[4] - 4.0 * values[0]) / (step * step);
  return true;
}

}  // namespace vsfind
