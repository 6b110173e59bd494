#include "photo.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace vsfind::render {
namespace {

std::array<double, 4> catmull_rom(double t) {
  return {0.5 * t * (-1.0 + t * (2.0 - t)), 1.0 + 0.5 * t * t * (-5.0 + 3.0 * t), 0.5 * t * (1.0 + t * (4.0 - 3.0 * t)),
          0.5 * t * t * (t - 1.0)};
}

}  // namespace

Photo::Photo(const ImageView& pixels) : width_(pixels.width), height_(pixels.height) {
  const double scale = std::ldexp(1.0, 8 - pixels.bits);
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) grey_.push_back(pixels.at(x, y) * scale);
  }
}

double Photo::at(double x, double y) const {
  const double left = std::floor(x);
  const double top = std::floor(y);
  const auto wx = catmull_rom(x - left);
  const auto wy = catmull_rom(y - top);
  double sum = 0.0;
  for (int k = 0; k < 4; ++k) {
    const int row = std::clamp(static_cast<int>(top) - 1 + k, 0, height_ - 1);
    const double* line = grey_.data() + static_cast<std::ptrdiff_t>(row) * width_;
    double part = 0.0;
    for (int i = 0; i < 4; ++i) {
      part += wx[static_cast<std::size_t>(i)] * line[std::clamp(static_cast<int>(left) - 1 + i, 0, width_ - 1)];
    }
    sum += wy[static_cast<std::size_t>(k)] * part;
  }
  return sum;
}

Exposure expose_photo(const Photo& photo, const Eigen::Vector2d& centre, double reduction, const Pose& pose, int width,
                      int height) {
  constexpr int samples = 8;
  const double angle = pose.angle_deg * std::numbers::pi / 180.0;
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  Exposure result{width, height, {}};
  result.grey.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      double sum = 0.0;
      for (int k = 0; k < samples; ++k) {
        for (int i = 0; i < samples; ++i) {
          const double dx = x + (i + 0.5) / samples - 0.5 - pose.x;
          const double dy = y + (k + 0.5) / samples - 0.5 - pose.y;
          sum += photo.at(centre.x() + reduction * (c * dx + s * dy) / pose.scale_x,
                          centre.y() + reduction * (c * dy - s * dx) / pose.scale_y);
        }
      }
      result.grey.push_back(static_cast<float>(sum / (samples * samples)));
    }
  }
  return result;
}

Roi richest_roi(const Exposure& exposure, int size, int margin) {
  Roi best;
  double most = -1.0;
  for (int top = margin; top + size + margin <= exposure.height; top += 4) {
    for (int left = margin; left + size + margin <= exposure.width; left += 4) {
      double xx = 0.0, xy = 0.0, yy = 0.0;
      for (int y = top + 1; y < top + size - 1; ++y) {
        for (int x = left + 1; x < left + size - 1; ++x) {
          const double gx = 0.5 * static_cast<double>(exposure.at(x + 1, y) - exposure.at(x - 1, y));
          const double gy = 0.5 * static_cast<double>(exposure.at(x, y + 1) - exposure.at(x, y - 1));
          xx += gx * gx;
          xy += gx * gy;
          yy += gy * gy;
        }
      }
      const double weakest = 0.5 * (xx + yy) - std::hypot(0.5 * (xx - yy), xy);
      if (weakest > most) {
        most = weakest;
        best = {left, top, size, size};
      }
    }
  }
  return best;
}

}  // namespace vsfind::render
