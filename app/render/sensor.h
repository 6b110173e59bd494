#pragma once
/// @file
/// What a camera makes of an exposure: shading, gain, gamma, noise, whole numbers.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "acquisition/image_view.h"
#include "app/render/scene.h"

namespace vsfind::render {

/// Grey levels are of 255 whatever the bits; a picture of more bits holds 2^(bits−8) times as much.
/// value = noise + 255·(((grey·gain + offset)·(1 + shade) + ramp) / 255)^gamma, clipped to what the bits can hold.
struct Sensor {
  double gain = 1.0;
  double offset = 0.0;
  double shade_x = 0.0;  ///< −1 … 1: multiplied by 1 − shade at the left border and 1 + shade at the right
  double shade_y = 0.0;
  double ramp_x = 0.0;  ///< grey levels: −ramp at the left border, +ramp at the right
  double ramp_y = 0.0;
  double gamma = 1.0;
  double noise = 2.0;  ///< standard deviation, grey levels
  std::uint64_t seed = 1;
  int bits = 8;
};

/// A picture that owns its pixels.
class Picture {
 public:
  Picture() = default;
  Picture(int width, int height, int bits);
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] int bits() const { return bits_; }
  [[nodiscard]] ImageView view() const;
  [[nodiscard]] std::vector<std::byte>& bytes() { return bytes_; }
  [[nodiscard]] const std::vector<std::byte>& bytes() const { return bytes_; }
  void set(int x, int y, int value);

 private:
  int width_ = 0;
  int height_ = 0;
  int bits_ = 8;
  std::vector<std::byte> bytes_;
};

/// The exposure before noise and rounding.
[[nodiscard]] Exposure illuminate(const Exposure& exposure, const Sensor& sensor);

[[nodiscard]] Picture develop(const Exposure& exposure, const Sensor& sensor);

/// An interlaced frame: the lines of the top field from `top`, of the bottom field from `bottom` (each of half the
/// rows, as expose() gives them), noise running over the whole frame.
[[nodiscard]] Exposure weave(const Exposure& top, const Exposure& bottom);

/// One field's lines as a picture of its own.
[[nodiscard]] Picture field_picture(const Picture& frame, Field field);

}  // namespace vsfind::render
