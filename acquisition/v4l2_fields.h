#pragma once
/// @file
/// V4L2 field orders as pure functions: how the lines of a frame lie in a buffer, and how they become a Frame.
///
/// | order         | a buffer holds                             | it becomes                                         |
/// |---------------|--------------------------------------------|----------------------------------------------------|
/// | none          | a progressive frame                        | that frame                                         |
/// | interlaced    | both fields line by line                   | a frame; order by the standard (525 lines: bottom) |
/// | interlaced_tb | both fields line by line, top line first   | a frame, top field first                           |
/// | interlaced_bt | likewise, top line first in memory too     | a frame, bottom field first                        |
/// | seq_tb        | the top field's lines, then the bottom's   | a woven frame, top field first                     |
/// | seq_bt        | the bottom field's lines, then the top's   | a woven frame, bottom field first                  |
/// | alternate     | one field, the buffer tells which          | a frame that is that field alone, without waiting  |
/// | top, bottom   | always that field                          | a frame that is that field alone                   |
///
/// Both fields of an alternating frame have the same sequence number.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "acquisition/frame.h"
#include "acquisition/v4l2_format.h"

namespace vsfind {

/// The numbers are V4L2's own.
enum class BufferFields : std::uint32_t {
  any = 0,
  none = 1,
  top = 2,
  bottom = 3,
  interlaced = 4,
  seq_tb = 5,
  seq_bt = 6,
  alternate = 7,
  interlaced_tb = 8,
  interlaced_bt = 9,
};

/// Every order that can be asked for, with its name; `any` leaves it to the driver.
inline constexpr std::array<std::pair<BufferFields, std::string_view>, 10> buffer_fields_names{{
    {BufferFields::any, "any"},
    {BufferFields::none, "none"},
    {BufferFields::top, "top"},
    {BufferFields::bottom, "bottom"},
    {BufferFields::interlaced, "interlaced"},
    {BufferFields::seq_tb, "seq_tb"},
    {BufferFields::seq_bt, "seq_bt"},
    {BufferFields::alternate, "alternate"},
    {BufferFields::interlaced_tb, "interlaced_tb"},
    {BufferFields::interlaced_bt, "interlaced_bt"},
}};

[[nodiscard]] std::string name(BufferFields fields);
/// Upper or lower case, `-` or `_`. Throws UsageError that names what is allowed.
[[nodiscard]] BufferFields parse_buffer_fields(const std::string& text);

/// Whether a buffer holds one field, of half the rows.
[[nodiscard]] constexpr bool holds_one_field(BufferFields fields) {
  return fields == BufferFields::top || fields == BufferFields::bottom || fields == BufferFields::alternate;
}
/// Rows of a whole frame, of which a buffer has that many.
[[nodiscard]] constexpr int frame_rows(BufferFields fields, int buffer_rows) {
  return holds_one_field(fields) ? 2 * buffer_rows : buffer_rows;
}
[[nodiscard]] constexpr int buffer_rows(BufferFields fields, int rows_of_frame) {
  return holds_one_field(fields) ? rows_of_frame / 2 : rows_of_frame;
}

/// Which field is exposed first. `lines_525`: the standard is one of 525 lines (NTSC, PAL-M …).
[[nodiscard]] FieldOrder field_order(BufferFields fields, bool lines_525);

/// What a buffer's picture is: a frame or a field. `format` is what the stream was set to, `buffer` what the buffer
/// itself says. Nothing where an alternating buffer does not say which field it is.
[[nodiscard]] std::optional<Field> picture_field(BufferFields format, BufferFields buffer);

/// Brings a buffer of `rows` rows into a Frame's form: luma to `target`, the lines of sequential fields to their
/// places.
void unpack(const LumaLayout& layout, BufferFields fields, const std::byte* source, std::ptrdiff_t source_stride,
            int width, int rows, std::byte* target, std::ptrdiff_t target_stride);

/// A driver's 32-bit sequence numbers as 64-bit ones from 0, and what is missing among them.
class SequenceCounter {
 public:
  /// `fields_per_frame`: 2 where buffers alternate between the fields, with one number for both of a frame;
  /// `first`: which of them is the earlier one.
  explicit SequenceCounter(int fields_per_frame = 1, Field first = Field::top)
      : fields_per_frame_(fields_per_frame), first_(first) {}

  /// The number of the next buffer. A driver that does not count, or starts again, is counted for.
  std::uint64_t next(std::uint32_t sequence, Field field);

  /// Buffers (frames, or fields where they alternate) that are missing before the last one, and altogether.
  [[nodiscard]] std::uint64_t missing_before() const { return missing_before_; }
  [[nodiscard]] std::uint64_t missing() const { return missing_; }

 private:
  int fields_per_frame_;
  Field first_;
  bool started_ = false;
  std::uint32_t last_sequence_ = 0;
  std::uint64_t last_position_ = 0;  // in buffers
  std::uint64_t missing_before_ = 0;
  std::uint64_t missing_ = 0;
};

}  // namespace vsfind
