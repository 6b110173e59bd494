#include "acquisition/v4l2_format.h"

#include <array>
#include <cctype>
#include <cstring>
#include <string_view>

namespace vsfind {
namespace {

constexpr std::uint32_t big_endian_bit = 1U << 31U;

constexpr std::uint32_t code(std::string_view name) {
  std::uint32_t fourcc = 0;
  for (unsigned i = 0; i < 4; ++i)
    fourcc |= static_cast<std::uint32_t>(static_cast<unsigned char>(i < name.size() ? name[i] : ' ')) << 8U * i;
  return fourcc;
}

struct Known {
  std::uint32_t fourcc;
  LumaLayout luma;
};
// clang-format off
constexpr std::array<Known, 33> known{{
    {code("GREY"), {8, 0, 1, false, 1, 1}},
    {code("Y10"), {10, 0, 2, false, 1, 1}},
    {code("Y12"), {12, 0, 2, false, 1, 1}},
    {code("Y14"), {14, 0, 2, false, 1, 1}},
    {code("Y16"), {16, 0, 2, false, 1, 1}},
    {code("Y16") | big_endian_bit, {16, 0, 2, true, 1, 1}},
    {code("YUYV"), {8, 0, 2, false, 1, 1}},
    {code("YVYU"), {8, 0, 2, false, 1, 1}},
    {code("UYVY"), {8, 1, 2, false, 1, 1}},
    {code("VYUY"), {8, 1, 2, false, 1, 1}},
    {code("NV12"), {8, 0, 1, false, 3, 2}},
    {code("NV21"), {8, 0, 1, false, 3, 2}},
    {code("NV16"), {8, 0, 1, false, 2, 1}},
    {code("NV61"), {8, 0, 1, false, 2, 1}},
    {code("NV24"), {8, 0, 1, false, 3, 1}},
    {code("NV42"), {8, 0, 1, false, 3, 1}},
    {code("YU12"), {8, 0, 1, false, 3, 2}},
    {code("YV12"), {8, 0, 1, false, 3, 2}},
    {code("422P"), {8, 0, 1, false, 2, 1}},
    {code("411P"), {8, 0, 1, false, 3, 2}},
    {code("YUV9"), {8, 0, 1, false, 9, 8}},
    {code("YVU9"), {8, 0, 1, false, 9, 8}},
    {code("444P"), {8, 0, 1, false, 3, 1}},
    // Planes in memories of their own: luma alone in the first.
    {code("NM12"), {8, 0, 1, false, 1, 1}},
    {code("NM21"), {8, 0, 1, false, 1, 1}},
    {code("NM16"), {8, 0, 1, false, 1, 1}},
    {code("NM61"), {8, 0, 1, false, 1, 1}},
    {code("YM12"), {8, 0, 1, false, 1, 1}},
    {code("YM21"), {8, 0, 1, false, 1, 1}},
    {code("YM16"), {8, 0, 1, false, 1, 1}},
    {code("YM61"), {8, 0, 1, false, 1, 1}},
    {code("YM24"), {8, 0, 1, false, 1, 1}},
    {code("YM42"), {8, 0, 1, false, 1, 1}},
}};
// clang-format on

}  // namespace

std::string fourcc_name(std::uint32_t fourcc) {
  std::string name;
  for (unsigned i = 0; i < 4; ++i) {
    const auto c = static_cast<unsigned char>(fourcc >> 8U * i & (i == 3 ? 0x7fU : 0xffU));
    name += c > 0x20 && c < 0x7f ? static_cast<char>(c) : c == ' ' ? ' ' : '?';
  }
  while (!name.empty() && name.back() == ' ') name.pop_back();
  if ((fourcc & big_endian_bit) != 0) name += "-BE";
  return name;
}

std::optional<std::uint32_t> fourcc_from_name(const std::string& name) {
  std::string_view text = name;
  std::uint32_t order = 0;
  if (text.ends_with("-BE") && text.size() > 3) {
    text.remove_suffix(3);
    order = big_endian_bit;
    while (text.ends_with(' ')) text.remove_suffix(1);
  }
  if (text.empty() || text.size() > 4) return std::nullopt;
  for (const char c : text) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) return std::nullopt;
  }
  return code(text) | order;
}

std::optional<LumaLayout> luma_layout(std::uint32_t fourcc) {
  for (const Known& format : known) {
    if (format.fourcc == fourcc) return format.luma;
  }
  return std::nullopt;
}

std::size_t picture_bytes(const LumaLayout& layout, std::size_t stride, std::size_t rows) {
  return stride * rows * static_cast<std::size_t>(layout.rows_numerator) /
         static_cast<std::size_t>(layout.rows_denominator);
}

void copy_luma(const LumaLayout& layout, const std::byte* source, std::ptrdiff_t source_stride, int width, int rows,
               std::byte* target, std::ptrdiff_t target_stride) {
  const auto columns = static_cast<std::size_t>(width);
  const auto mask = static_cast<std::uint16_t>((1U << static_cast<unsigned>(layout.bits)) - 1U);
  for (int y = 0; y < rows; ++y) {
    const std::byte* from = source + y * source_stride + layout.offset;
    std::byte* to = target + y * target_stride;
    if (layout.bits <= 8 && layout.step == 1) {
      std::memcpy(to, from, columns);
    } else if (layout.bits <= 8) {
      const auto step = static_cast<std::size_t>(layout.step);
      if (step == 2) {
        for (std::size_t x = 0; x < columns; ++x) to[x] = from[2 * x];
      } else {
        for (std::size_t x = 0; x < columns; ++x) to[x] = from[step * x];
      }
    } else {
      const unsigned low = layout.big_endian ? 1 : 0;
      auto* samples = reinterpret_cast<std::uint16_t*>(to);
      for (std::size_t x = 0; x < columns; ++x) {
        const auto value = static_cast<unsigned>(from[2 * x + low]) | static_cast<unsigned>(from[2 * x + 1 - low])
                                                                          << 8U;
        samples[x] = static_cast<std::uint16_t>(value & mask);
      }
    }
  }
}

bool is_jpeg(std::uint32_t fourcc) { return fourcc == code("MJPG") || fourcc == code("JPEG"); }

bool jpeg_is_whole(std::span<const std::byte> picture) {
  const auto byte = [&](std::size_t at) { return static_cast<unsigned>(picture[at]); };
  if (picture.size() < 4 || byte(0) != 0xff || byte(1) != 0xd8) return false;
  // Segments up to the begin of the scan; one of them may hold a thumbnail with an end of its own.
  std::size_t at = 2;
  for (;;) {
    while (at + 1 < picture.size() && byte(at) == 0xff && byte(at + 1) == 0xff) ++at;  // fill bytes
    if (at + 4 > picture.size() || byte(at) != 0xff) return false;
    const bool scan = byte(at + 1) == 0xda;
    at += 2 + (byte(at + 2) << 8U | byte(at + 3));
    if (scan) break;
  }
  // Within a scan 0xff is followed by 0 or a restart marker.
  for (; at + 1 < picture.size(); ++at) {
    if (byte(at) == 0xff && byte(at + 1) == 0xd9) return true;
  }
  return false;
}

}  // namespace vsfind
