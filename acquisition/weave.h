#pragma once
/// @file
/// Two fields put together into a frame: the inverse of field_view(), for sources whose fields lie or come apart.

#include <cstddef>

#include "acquisition/image_view.h"

namespace vsfind {

/// Copies a field's rows to their lines of a frame (row r to line 2r, of the bottom field to 2r+1) that begins at
/// `frame` with `stride` bytes from a line to the next; the other lines stay as they are. `Field::frame` copies every
/// line. The picture must not lie in the frame.
void weave_field(const ImageView& picture, Field field, std::byte* frame, std::ptrdiff_t stride);

/// Both fields; returns the frame's view. Throws UsageError unless they agree in width and bits, and in height but for
/// one more row of the top field.
ImageView weave(const ImageView& top, const ImageView& bottom, std::byte* frame, std::ptrdiff_t stride);

}  // namespace vsfind
