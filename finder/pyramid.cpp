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

void smooth(const Level& level, std::vector<std::uint16_t>& sums, std::uint8_t* out) {
  const int w = level.width;
  const int h = level.height;
  sums.resize(static_cast<std::size_t>(w));
  for (int v = 0; v < h; ++v) {
    const std::uint8_t* above = level.row(std::max(v - 1, 0));
    const std::uint8_t* here = level.row(v);
    const std::uint8_t* below = level.row(std::min(v + 1, h - 1));
    for (int u = 0; u < w; ++u) {
      sums[static_cast<std::size_t>(u)] = static_cast<std::uint16_t>(above[u] + 2 * here[u] + below[u]);
    }
    std::uint8_t* to = out + static_cast<std::ptrdiff_t>(v) * w;
    const std::uint16_t* s = sums.data();
    to[0] = static_cast<std::uint8_t>((3 * s[0] + s[std::min(1, w - 1)] + 8) >> 4);
    for (int u = 1; u + 1 < w; ++u) to[u] = static_cast<std::uint8_t>((s[u - 1] + 2 * s[u] + s[u + 1] + 8) >> 4);
    if (w > 1) to[w - 1] = static_cast<std::uint8_t>((s[w - 2] + 3 * s[w - 1] + 8) >> 4);
  }
}

const Level& Pyramid::smoothed(int index) {
  Smoothed& s = smoothed_[static_cast<std::size_t>(index)];
  if (!s.fresh) {
    s.level = level(index);
    s.memory.resize(static_cast<std::size_t>(s.level.width) * static_cast<std::size_t>(s.level.height) +
                    kernels::read_slack);
    smooth(level(index), sums_, s.memory.data());
    s.level.data = s.memory.data();
    s.level.stride = s.level.width;
    s.fresh = true;
  }
  return s.level;
}

void Pyramid::build(const ImageView& image, const HalvingPlan& plan) {
  levels_.clear();
  memory_.resize(plan.steps.size() + 1);
  smoothed_.resize(plan.steps.size() + 1);
  for (Smoothed& each : smoothed_) each.fresh = false;
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
