#include "acquisition/weave.h"

#include <fmt/format.h>

#include <cstring>

#include "acquisition/errors.h"

namespace vsfind {

void weave_field(const ImageView& picture, Field field, std::byte* frame, std::ptrdiff_t stride) {
  if (picture.empty()) return;
  const auto row_bytes = static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.bytes_per_pixel());
  for (int row = 0; row < picture.height; ++row) {
    const std::ptrdiff_t line = std::ptrdiff_t{row} * line_step(field) + first_line(field);
    std::memcpy(frame + line * stride, picture.data + row * picture.stride, row_bytes);
  }
}

ImageView weave(const ImageView& top, const ImageView& bottom, std::byte* frame, std::ptrdiff_t stride) {
  const int more = top.height - bottom.height;
  if (top.width != bottom.width || top.bits != bottom.bits || more < 0 || more > 1)
    throw UsageError(fmt::format("fields of {}x{} ({} bits) and {}x{} ({} bits) pixels do not make a frame", top.width,
                                 top.height, top.bits, bottom.width, bottom.height, bottom.bits));
  weave_field(top, Field::top, frame, stride);
  weave_field(bottom, Field::bottom, frame, stride);
  return {frame, top.width, top.height + bottom.height, stride, top.bits};
}

}  // namespace vsfind
