#include "app/render/sensor.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "app/render/random.h"

namespace vsfind::render {

Picture::Picture(int width, int height, int bits)
    : width_(width),
      height_(height),
      bits_(bits),
      bytes_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * (bits > 8 ? 2U : 1U)) {}

ImageView Picture::view() const {
  return {bytes_.data(), width_, height_, static_cast<std::ptrdiff_t>(width_) * (bits_ > 8 ? 2 : 1), bits_};
}

void Picture::set(int x, int y, int value) {
  const auto index = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  if (bits_ > 8) {
    const auto wide = static_cast<std::uint16_t>(value);
    std::memcpy(bytes_.data() + 2 * index, &wide, 2);
  } else {
    bytes_[index] = static_cast<std::byte>(value);
  }
}

Exposure illuminate(const Exposure& exposure, const Sensor& sensor) {
  Exposure result = exposure;
  const double half_x = std::max(1.0, (exposure.width - 1) / 2.0);
  const double half_y = std::max(1.0, (exposure.height - 1) / 2.0);
  for (int y = 0; y < exposure.height; ++y) {
    const double v = y / half_y - 1.0;
    for (int x = 0; x < exposure.width; ++x) {
      const double u = x / half_x - 1.0;
      float& grey = result.grey[static_cast<std::size_t>(y) * static_cast<std::size_t>(exposure.width) +
                                static_cast<std::size_t>(x)];
      double value =
          (static_cast<double>(grey) * sensor.gain + sensor.offset) * (1.0 + sensor.shade_x * u + sensor.shade_y * v);
      value += sensor.ramp_x * u + sensor.ramp_y * v;
      if (sensor.gamma != 1.0) value = 255.0 * std::pow(std::clamp(value / 255.0, 0.0, 1.0), sensor.gamma);
      grey = static_cast<float>(value);
    }
  }
  return result;
}

Picture develop(const Exposure& exposure, const Sensor& sensor) {
  const Exposure lit = illuminate(exposure, sensor);
  Picture picture(exposure.width, exposure.height, sensor.bits);
  Random random(sensor.seed);
  const double scale = std::ldexp(1.0, sensor.bits - 8);
  const double white = picture.view().white();
  for (int y = 0; y < lit.height; ++y) {
    for (int x = 0; x < lit.width; ++x) {
      const double noisy =
          static_cast<double>(lit.at(x, y)) + (sensor.noise > 0.0 ? sensor.noise * random.normal() : 0.0);
      picture.set(x, y, static_cast<int>(std::floor(std::clamp(noisy * scale + 0.5, 0.0, white + 0.5))));
    }
  }
  return picture;
}

Exposure weave(const Exposure& top, const Exposure& bottom) {
  Exposure frame;
  frame.width = top.width;
  frame.height = top.height + bottom.height;
  frame.grey.resize(top.grey.size() + bottom.grey.size());
  const auto width = static_cast<std::ptrdiff_t>(top.width);
  for (std::ptrdiff_t y = 0; y < frame.height; ++y) {
    const Exposure& source = y % 2 == 0 ? top : bottom;
    std::copy_n(source.grey.begin() + y / 2 * width, width, frame.grey.begin() + y * width);
  }
  return frame;
}

Picture field_picture(const Picture& frame, Field field) {
  const ImageView lines = field_view(frame.view(), field);
  Picture result(lines.width, lines.height, lines.bits);
  const auto row_bytes = static_cast<std::size_t>(lines.width) * static_cast<std::size_t>(lines.bytes_per_pixel());
  for (int y = 0; y < lines.height; ++y) {
    std::memcpy(result.bytes().data() + static_cast<std::size_t>(y) * row_bytes, lines.data + y * lines.stride,
                row_bytes);
  }
  return result;
}

}  // namespace vsfind::render
