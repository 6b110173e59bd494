#include "finder/pyramid.h"

#include <algorithm>

#include "finder/kernels.h"

namespace vsfind {

namespace {
constexpr int smallest_side = 8;
}

HalvingPlan HalvingPlan::for_pixel_size(double width, double height, int levels) {
  HalvingPlan plan;
  constexpr double alike = 1.42;
  for (int i = 0; i < levels; ++i) {
    Step step;
    if (height > width * alike) step.y = false;
    if (width > height * alike) step.x = false;
    if (step.x) width *= 2.0;
    if (step.y) height *= 2.0;
    plan.steps.push_back(step);
  }
  return plan;
}

void narrow_to_8_bits(const ImageView& image, std::vector<std::uint8_t>& out) {
  out.resize(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) + kernels::read_slack);
  const int shift = image.bits - 8;
  for (int y = 0; y < image.height; ++y) {
    const std::uint16_t* in = image.row16(y);
    std::uint8_t* to = out.data() + static_cast<std::ptrdiff_t>(y) * image.width;
    for (int x = 0; x < image.width; ++x) to[x] = static_cast<std::uint8_t>(std::min(in[x] >> shift, 255));
  }
}

void Pyramid::build(const ImageView& image, const HalvingPlan& plan) {
  levels_.clear();
  memory_.resize(plan.steps.size() + 1);
  Level base;
  base.width = image.width;
  base.height = image.height;
  if (image.bits > 8) {
    narrow_to_8_bits(image, memory_[0]);
    base.data = memory_[0].data();
    base.stride = image.width;
  } else {
    base.data = reinterpret_cast<const std::uint8_t*>(image.data);
    base.stride = image.stride;
  }
  levels_.push_back(base);
  for (std::size_t i = 0; i < plan.steps.size(); ++i) {
    const HalvingPlan::Step step = plan.steps[i];
    const Level from = levels_.back();
    Level to = from;
    if (step.x) {
      to.width = from.width / 2;
      to.offset_x = from.offset_x + 0.5 * from.step_x;
      to.step_x = from.step_x * 2.0;
    }
    if (step.y) {
      to.height = from.height / 2;
      to.offset_y = from.offset_y + 0.5 * from.step_y;
      to.step_y = from.step_y * 2.0;
    }
    if (to.width < smallest_side || to.height < smallest_side) break;
    std::vector<std::uint8_t>& memory = memory_[i + 1];
    memory.resize(static_cast<std::size_t>(to.width) * static_cast<std::size_t>(to.height) + kernels::read_slack);
    to.data = memory.data();
    to.stride = to.width;
    for (int v = 0; v < to.height; ++v) {
      std::uint8_t* out = memory.data() + static_cast<std::ptrdiff_t>(v) * to.width;
      if (step.x && step.y) {
        kernels::halve_both(from.row(2 * v), from.row(2 * v + 1), out, to.width);
      } else if (step.x) {
        kernels::halve_x(from.row(v), out, to.width);
      } else {
        kernels::halve_y(from.row(2 * v), from.row(2 * v + 1), out, to.width);
      }
    }
    levels_.push_back(to);
  }
}

}  // namespace vsfind
