#pragma once
/// @file
/// A picture at halved and halved resolutions, in 8 bits.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "acquisition/image_view.h"

namespace vsfind {

/// One level: 8-bit pixels and where they lie in the picture. Pixel (u,v) covers the picture around
/// (offset_x + step_x·u, offset_y + step_y·v).
struct Level {
  const std::uint8_t* data = nullptr;
  int width = 0;
  int height = 0;
  std::ptrdiff_t stride = 0;
  double step_x = 1.0;  ///< picture pixels from a level pixel to the next
  double step_y = 1.0;
  double offset_x = 0.0;
  double offset_y = 0.0;

  [[nodiscard]] const std::uint8_t* row(int v) const { return data + v * stride; }
  [[nodiscard]] Eigen::Vector2d image_from_level(const Eigen::Vector2d& p) const {
    return {offset_x + step_x * p.x(), offset_y + step_y * p.y()};
  }
  [[nodiscard]] Eigen::Vector2d level_from_image(const Eigen::Vector2d& p) const {
    return {(p.x() - offset_x) / step_x, (p.y() - offset_y) / step_y};
  }
};

/// Which axes each step halves. A field has lines twice as far apart as its columns: its first step halves along x
/// only, and from there on its levels are those of the frame.
struct HalvingPlan {
  struct Step {
    bool x = true;
    bool y = true;
  };
  std::vector<Step> steps;

  /// For pixels of the given size (any unit): at each step the axis with the finer pixels is halved alone until both
  /// are alike within a factor of √2.
  [[nodiscard]] static HalvingPlan for_pixel_size(double width, double height, int levels);
};

/// Keeps its memory between pictures.
class Pyramid {
 public:
  /// Levels 0 … plan.steps.size(), as far as a level has at least 8 pixels either way. Level 0 is the picture itself
  /// where it has 8 bits (its memory must live on), else its upper 8 bits.
  void build(const ImageView& image, const HalvingPlan& plan);

  [[nodiscard]] int levels() const { return static_cast<int>(levels_.size()); }
  [[nodiscard]] const Level& level(int index) const { return levels_[static_cast<std::size_t>(index)]; }
  /// The same level smoothed by [1 2 1]/4 both ways, made when first asked for: halving lets through more than a level
  /// can hold, and what is aliased changes with every sub-pixel shift. Not for use by two threads at once.
  [[nodiscard]] const Level& smoothed(int index);

 private:
  struct Smoothed {
    Level level;
    std::vector<std::uint8_t> memory;
    bool fresh = false;
  };

  std::vector<Level> levels_;
  std::vector<std::vector<std::uint8_t>> memory_;
  std::vector<Smoothed> smoothed_;
  std::vector<std::uint16_t> sums_;  // scratch of smoothed()
};

/// Smooths by [1 2 1]/4 both ways; the border's pixels stand for those beyond it. `sums` is scratch; `out`: width ·
/// height.
void smooth(const Level& level, std::vector<std::uint16_t>& sums, std::uint8_t* out);

/// Upper 8 bits of a picture of 9 to 16 bits, row by row.
void narrow_to_8_bits(const ImageView& image, std::vector<std::uint8_t>& out);

}  // namespace vsfind
