#include "acquisition/v4l2_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "acquisition/errors.h"

namespace vsfind {

std::string name(BufferFields fields) {
  for (const auto& [value, word] : buffer_fields_names) {
    if (value == fields) return std::string(word);
  }
  return fmt::format("unknown field order {}", static_cast<std::uint32_t>(fields));
}

BufferFields parse_buffer_fields(const std::string& text) {
  std::string wanted = text;
  for (char& c : wanted) c = c == '-' ? '_' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  std::string allowed;
  for (const auto& [value, word] : buffer_fields_names) {
    if (word == wanted) return value;
    allowed += fmt::format("{}{}", allowed.empty() ? "" : ", ", word);
  }
  throw UsageError(fmt::format("field order '{}' is not known (allowed: {})", text, allowed));
}

FieldOrder field_order(BufferFields fields, bool lines_525) {
  switch (fields) {
    case BufferFields::any:
    case BufferFields::none:
      return FieldOrder::progressive;
    case BufferFields::interlaced_tb:
    case BufferFields::seq_tb:
      return FieldOrder::top_first;
    case BufferFields::interlaced_bt:
    case BufferFields::seq_bt:
      return FieldOrder::bottom_first;
    case BufferFields::top:
    case BufferFields::bottom:
    case BufferFields::interlaced:
    case BufferFields::alternate:
      break;
  }
  return lines_525 ? FieldOrder::bottom_first : FieldOrder::top_first;
}

std::optional<Field> picture_field(BufferFields format, BufferFields buffer) {
  if (format == BufferFields::top) return Field::top;
  if (format == BufferFields::bottom) return Field::bottom;
  if (format != BufferFields::alternate) return Field::frame;
  if (buffer == BufferFields::top) return Field::top;
  if (buffer == BufferFields::bottom) return Field::bottom;
  return std::nullopt;
}

void unpack(const LumaLayout& layout, BufferFields fields, const std::byte* source, std::ptrdiff_t source_stride,
            int width, int rows, std::byte* target, std::ptrdiff_t target_stride) {
  if (fields != BufferFields::seq_tb && fields != BufferFields::seq_bt) {
    copy_luma(layout, source, source_stride, width, rows, target, target_stride);
    return;
  }
  // Of an odd number of rows the top field has one more.
  const int top_rows = (rows + 1) / 2;
  const int bottom_rows = rows / 2;
  const bool top_stored_first = fields == BufferFields::seq_tb;
  const std::byte* top = source + (top_stored_first ? 0 : bottom_rows * source_stride);
  const std::byte* bottom = source + (top_stored_first ? top_rows * source_stride : 0);
  copy_luma(layout, top, source_stride, width, top_rows, target, 2 * target_stride);
  copy_luma(layout, bottom, source_stride, width, bottom_rows, target + target_stride, 2 * target_stride);
}

std::uint64_t SequenceCounter::next(std::uint32_t sequence, Field field) {
  const auto per_frame = static_cast<std::uint64_t>(fields_per_frame_);
  const std::uint64_t within = per_frame == 2 && field != first_ ? 1 : 0;
  missing_before_ = 0;
  if (!started_) {
    started_ = true;
    last_position_ = within;
  } else {
    // Wraps at 32 bits; a number far behind is a counter that started again.
    const auto step = static_cast<std::int32_t>(sequence - last_sequence_);
    const std::uint64_t frame = last_position_ / per_frame;
    const std::uint64_t position =
        step < 0 ? last_position_ : (frame + static_cast<std::uint64_t>(step)) * per_frame + within;
    if (position > last_position_) {
      missing_before_ = position - last_position_ - 1;
      last_position_ = position;
    } else {
      // The driver does not count, or starts again: the next place that this field can have.
      last_position_ += 1;
      if (per_frame == 2 && last_position_ % 2 != within) ++last_position_;
    }
    missing_ += missing_before_;
  }
  last_sequence_ = sequence;
  return last_position_ / per_frame;
}

}  // namespace vsfind
