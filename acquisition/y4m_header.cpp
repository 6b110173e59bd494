#include "acquisition/y4m_header.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <limits>
#include <numeric>

#include "acquisition/errors.h"

namespace vsfind {
namespace {

constexpr std::string_view stream_magic = "YUV4MPEG2";
constexpr std::string_view frame_magic = "FRAME";
constexpr std::string_view tag_key = "VSFIND=";

/// Takes the next word off `rest`; empty at the end.
std::string_view next_word(std::string_view& rest) {
  const std::size_t begin = rest.find_first_not_of(' ');
  if (begin == std::string_view::npos) return rest = {};
  const std::size_t end = std::min(rest.find(' ', begin), rest.size());
  const std::string_view word = rest.substr(begin, end - begin);
  rest.remove_prefix(end);
  return word;
}

template <typename Number>
bool parse_number(std::string_view text, Number& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc{} && end == text.data() + text.size();
}

int parse_side(std::string_view value, const char* what) {
  std::int64_t side = 0;
  if (!parse_number(value, side) || side < 1 || side > y4m_max_side)
    throw IoError(fmt::format("bad {} {} in the header: allowed are 1 to {}", what, quoted(value), y4m_max_side));
  return static_cast<int>(side);
}

Ratio parse_ratio(std::string_view value, const char* what) {
  const std::size_t colon = value.find(':');
  Ratio ratio;
  constexpr std::int64_t limit = std::numeric_limits<std::int32_t>::max();
  if (colon == std::string_view::npos || !parse_number(value.substr(0, colon), ratio.numerator) ||
      !parse_number(value.substr(colon + 1), ratio.denominator) || ratio.numerator < 0 || ratio.denominator < 0 ||
      ratio.numerator > limit || ratio.denominator > limit)
    throw IoError(fmt::format("bad {} {} in the header: allowed are N:D with whole numbers, 0:0 for unknown", what,
                              quoted(value)));
  return ratio.known() ? ratio : Ratio{};
}

void parse_order(std::string_view value, Y4mHeader& header) {
  if (value == "p") {
    header.order = FieldOrder::progressive;
  } else if (value == "t") {
    header.order = FieldOrder::top_first;
  } else if (value == "b") {
    header.order = FieldOrder::bottom_first;
  } else if (value == "m" || value == "?") {
    header.order = FieldOrder::unknown;
  } else {
    throw IoError(fmt::format("bad interlacing {} in the header: allowed are p, t, b, m, ?", quoted(value)));
  }
  header.mixed = value == "m";
}

/// How the chroma planes are stored: their number, and how many luma columns and rows share a sample.
struct Chroma {
  std::string_view name;
  int planes;
  int columns;
  int rows;
};
constexpr std::array<Chroma, 8> chromas{{{"420", 2, 2, 2},
                                         {"422", 2, 2, 1},
                                         {"444", 2, 1, 1},
                                         {"411", 2, 4, 1},
                                         {"410", 2, 4, 4},
                                         {"440", 2, 1, 2},
                                         {"444alpha", 3, 1, 1},
                                         {"mono", 0, 1, 1}}};
constexpr std::string_view colour_spaces =
    "mono, mono9 to mono16, 420, 420jpeg, 420mpeg2, 420paldv, 422, 444, 444alpha, 440, 411, 410, and 420p9 to 444p16";

/// Fills bits and the planes' sizes.
void parse_colour_space(std::string_view value, Y4mHeader& header) {
  std::string_view name = value;
  int bits = 8;
  if (value == "420jpeg" || value == "420mpeg2" || value == "420paldv") {
    name = "420";
  } else if (value.starts_with("mono") && value.size() > 4) {
    name = "mono";
    if (!parse_number(value.substr(4), bits) || bits < 9) bits = 0;
  } else if (value.size() > 4 && value[3] == 'p') {
    name = value.substr(0, 3);
    if (!parse_number(value.substr(4), bits) || bits < 9) bits = 0;
  }
  for (const Chroma& chroma : chromas) {
    if (name != chroma.name || bits < 8 || bits > 16) continue;
    const auto columns = static_cast<std::size_t>((header.width + chroma.columns - 1) / chroma.columns);
    const auto rows = static_cast<std::size_t>((header.height + chroma.rows - 1) / chroma.rows);
    const std::size_t bytes = bits > 8 ? 2 : 1;
    header.bits = bits;
    header.luma_bytes = static_cast<std::size_t>(header.width) * static_cast<std::size_t>(header.height) * bytes;
    header.chroma_bytes = columns * rows * static_cast<std::size_t>(chroma.planes) * bytes;
    return;
  }
  throw IoError(fmt::format("unknown colour space {} in the header: allowed are {}", quoted(value), colour_spaces));
}

/// The I parameter of a frame's line: presentation, temporal sampling, spatial sampling. A frame sampled at one time
/// is progressive in whatever order its fields are shown.
FieldOrder parse_frame_order(std::string_view value) {
  const char presentation = value.empty() ? '?' : value[0];
  const bool one_time = value.size() > 1 && value[1] == 'p';
  switch (presentation) {
    case '1':
    case '2':
    case '3':
      return FieldOrder::progressive;
    case 't':
    case 'T':
      return one_time ? FieldOrder::progressive : FieldOrder::top_first;
    case 'b':
    case 'B':
      return one_time ? FieldOrder::progressive : FieldOrder::bottom_first;
    default:
      return FieldOrder::unknown;
  }
}

// The letters of a tag, in the order of the enumerators.
constexpr std::string_view clock_letters = "nmrdf";
constexpr std::string_view status_letters = "gic";
constexpr std::string_view field_letters = "ftb";
constexpr std::string_view order_letters = "ptbu";
constexpr std::string_view picture_letters = "ie";
constexpr std::string_view stamped_letters = "use";

template <typename Value>
bool parse_letter(std::string_view letters, char letter, Value& value) {
  const std::size_t at = letters.find(letter);
  if (at == std::string_view::npos) return false;
  value = static_cast<Value>(at);
  return true;
}

template <typename Value>
char letter_of(std::string_view letters, Value value) {
  return letters[static_cast<std::size_t>(value)];
}

Y4mTag parse_tag(std::string_view value) {
  Y4mTag tag;
  const std::size_t first = value.find(',');
  const std::size_t second = first == std::string_view::npos ? first : value.find(',', first + 1);
  bool good = second != std::string_view::npos && value.size() - second - 1 >= 5;
  if (good) {
    std::string_view time = value.substr(first + 1, second - first - 1);
    if (time.starts_with('+')) time.remove_prefix(1);
    const std::string_view letters = value.substr(second + 1);
    good = parse_number(value.substr(0, first), tag.sequence) && parse_number(time, tag.timestamp_ns) &&
           parse_letter(clock_letters, letters[0], tag.clock) && parse_letter(status_letters, letters[1], tag.status) &&
           parse_letter(field_letters, letters[2], tag.field) && parse_letter(order_letters, letters[3], tag.order) &&
           parse_letter(picture_letters, letters[4], tag.empty);
    // What follows is of later versions: not to be complained of.
    if (good && letters.size() > 5) static_cast<void>(parse_letter(stamped_letters, letters[5], tag.stamped_at));
  }
  if (!good) throw IoError(fmt::format("bad parameter {}", quoted(fmt::format("X{}{}", tag_key, value))));
  return tag;
}

/// Reduced, and with both parts small enough for everybody's int.
Ratio written(Ratio ratio) {
  if (!ratio.known()) return {};
  const std::int64_t common = std::gcd(ratio.numerator, ratio.denominator);
  ratio = {ratio.numerator / common, ratio.denominator / common};
  while (std::max(ratio.numerator, ratio.denominator) > std::numeric_limits<std::int32_t>::max())
    ratio = {ratio.numerator / 2, ratio.denominator / 2};
  return ratio.known() ? ratio : Ratio{};
}

}  // namespace

std::string quoted(std::string_view bytes) {
  constexpr std::size_t longest = 40;
  std::string text = "'";
  for (const char c : bytes.substr(0, longest)) {
    const auto code = static_cast<unsigned char>(c);
    text += code >= 0x20 && code < 0x7f ? std::string(1, c) : fmt::format("\\x{:02x}", code);
  }
  text += bytes.size() > longest ? "…'" : "'";
  return text;
}

Y4mHeader parse_y4m_header(std::string_view line) {
  std::string_view rest = line;
  if (next_word(rest) != stream_magic || !line.starts_with(stream_magic))
    throw IoError(fmt::format("not a YUV4MPEG2 recording: it begins with {}, not with 'YUV4MPEG2 '", quoted(line)));
  Y4mHeader header;
  std::string_view colour_space = "420jpeg";
  for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest)) {
    const std::string_view value = word.substr(1);
    switch (word[0]) {
      case 'W':
        header.width = parse_side(value, "width");
        break;
      case 'H':
        header.height = parse_side(value, "height");
        break;
      case 'F':
        header.frame_rate = parse_ratio(value, "frame rate");
        break;
      case 'A':
        header.pixel_aspect = parse_ratio(value, "pixel aspect");
        break;
      case 'I':
        parse_order(value, header);
        break;
      case 'C':
        colour_space = value;
        break;
      default:  // X: for other programs; anything else: a later version of the format
        break;
    }
  }
  if (header.width == 0) throw IoError("the header tells no width (W): allowed are 1 to 65536");
  if (header.height == 0) throw IoError("the header tells no height (H): allowed are 1 to 65536");
  if (static_cast<std::int64_t>(header.width) * header.height > y4m_max_pixels)
    throw IoError(fmt::format("frames of {}x{} pixels are too large: at most {} pixels are allowed", header.width,
                              header.height, y4m_max_pixels));
  parse_colour_space(colour_space, header);
  return header;
}

Y4mFrameLine parse_y4m_frame_line(std::string_view line) {
  std::string_view rest = line;
  if (next_word(rest) != frame_magic || !line.starts_with(frame_magic))
    throw IoError(fmt::format("it begins with {}, not with 'FRAME'", quoted(line)));
  Y4mFrameLine result;
  for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest)) {
    const std::string_view value = word.substr(1);
    if (word[0] == 'I') result.order = parse_frame_order(value);
    if (word[0] == 'X' && value.starts_with(tag_key)) result.tag = parse_tag(value.substr(tag_key.size()));
  }
  return result;
}

std::string format_y4m_header(const Y4mHeader& header) {
  const char order = header.order == FieldOrder::progressive    ? 'p'
                     : header.order == FieldOrder::top_first    ? 't'
                     : header.order == FieldOrder::bottom_first ? 'b'
                                                                : '?';
  const Ratio rate = written(header.frame_rate);
  const Ratio aspect = written(header.pixel_aspect);
  return fmt::format("{} W{} H{} F{}:{} I{} A{}:{} Cmono{}\n", stream_magic, header.width, header.height,
                     rate.numerator, rate.denominator, order, aspect.numerator, aspect.denominator,
                     header.bits > 8 ? std::to_string(header.bits) : std::string());
}

std::string format_y4m_frame_line(const Y4mTag& tag) {
  return fmt::format("{} X{}{:020d},{:+020d},{}{}{}{}{}{}\n", frame_magic, tag_key, tag.sequence, tag.timestamp_ns,
                     letter_of(clock_letters, tag.clock), letter_of(status_letters, tag.status),
                     letter_of(field_letters, tag.field), letter_of(order_letters, tag.order),
                     letter_of(picture_letters, tag.empty), letter_of(stamped_letters, tag.stamped_at));
}

}  // namespace vsfind
