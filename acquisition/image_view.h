#pragma once
/// @file
/// A picture in memory that somebody else owns, and its fields.
///
/// Coordinates, here and everywhere in vsfind: x right, y down, an integer is a pixel centre, (0,0) is the centre of
/// the top-left pixel. Row r of the top field is frame row 2r, row r of the bottom field is frame row 2r+1.

#include <cstddef>
#include <cstdint>

namespace vsfind {

/// Which lines of a frame a picture holds.
enum class Field : std::uint8_t {
  frame,   ///< every line
  top,     ///< lines 0, 2, 4, … of the frame
  bottom,  ///< lines 1, 3, 5, … of the frame
};

/// A mono picture, not owned. Valid as long as its owner (a Frame, a cv::Mat, a buffer) lives.
struct ImageView {
  const std::byte* data = nullptr;  ///< first pixel of the first row
  int width = 0;                    ///< pixels
  int height = 0;                   ///< rows
  std::ptrdiff_t stride = 0;        ///< bytes from a row to the next
  int bits = 8;                     ///< significant bits: 8 in one byte, 9 to 16 in a native-endian uint16_t

  [[nodiscard]] bool empty() const { return data == nullptr || width <= 0 || height <= 0; }
  [[nodiscard]] int bytes_per_pixel() const { return bits > 8 ? 2 : 1; }
  [[nodiscard]] double white() const { return static_cast<double>((1U << static_cast<unsigned>(bits)) - 1U); }

  /// Row y of an 8-bit picture.
  [[nodiscard]] const std::uint8_t* row8(int y) const {
    return reinterpret_cast<const std::uint8_t*>(data + y * stride);
  }
  /// Row y of a picture of more than 8 bits. Rows are 2-byte aligned.
  [[nodiscard]] const std::uint16_t* row16(int y) const {
    return reinterpret_cast<const std::uint16_t*>(data + y * stride);
  }
  /// Grey value at a pixel inside the picture.
  [[nodiscard]] int at(int x, int y) const { return bits > 8 ? row16(y)[x] : row8(y)[x]; }
};

/// The lines of one field as a view into the frame's own memory: twice the stride, half the rows. Of an odd number of
/// rows the top field has one more. `Field::frame` gives the frame itself.
[[nodiscard]] inline ImageView field_view(const ImageView& frame, Field field) {
  if (field == Field::frame) return frame;
  ImageView view = frame;
  const bool bottom = field == Field::bottom;
  view.height = bottom ? frame.height / 2 : (frame.height + 1) / 2;
  view.stride = frame.stride * 2;
  if (bottom) view.data = frame.data + frame.stride;
  return view;
}

/// The first line of the field within its frame: 0, or 1 for the bottom field.
[[nodiscard]] constexpr int first_line(Field field) { return field == Field::bottom ? 1 : 0; }
/// Frame lines from one line of the picture to the next: 1 for a frame, 2 for a field.
[[nodiscard]] constexpr int line_step(Field field) { return field == Field::frame ? 1 : 2; }
/// "frame", "top" or "bottom", as in the results.
[[nodiscard]] constexpr const char* name(Field field) {
  return field == Field::top ? "top" : field == Field::bottom ? "bottom" : "frame";
}

}  // namespace vsfind
