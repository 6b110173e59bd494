#pragma once
/// @file
/// The frames that the guest shows through vivid's output, and that the host expects in its recordings, made from the
/// frame's number alone: the recorded sequence of tests/data/interlaced in the middle, noise that differs from frame to
/// frame around it, and the number itself in the first pixels of lines 0 and 1, so that either field tells it.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/image_view.h"

namespace vsfind::test {

/// Where the recorded sequence lies in a shown frame; an even line, so that its fields are the shown ones.
struct Placement {
  int x;
  int y;
};

class ShownFrames {
 public:
  /// `recording`: tests/data/interlaced/conveyor.y4m.
  ShownFrames(const std::string& recording, int width, int height);

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] Placement placement() const { return placement_; }
  /// How many frames the recorded sequence has; shown frame N holds number N modulo that.
  [[nodiscard]] std::uint32_t recorded() const { return static_cast<std::uint32_t>(recorded_.size()); }

  /// Draws frame `number`, 8 bits, rows without gaps.
  void draw(std::uint32_t number, std::vector<std::uint8_t>& picture) const;

 private:
  int width_;
  int height_;
  Placement placement_;
  int recorded_width_ = 0;
  int recorded_height_ = 0;
  std::vector<std::vector<std::uint8_t>> recorded_;
};

/// The number in a frame or a field of it; nothing where none is.
[[nodiscard]] std::optional<std::uint32_t> shown_number(const ImageView& picture);

}  // namespace vsfind::test
