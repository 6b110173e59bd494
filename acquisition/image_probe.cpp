#include "acquisition/image_probe.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "acquisition/errors.h"
#include "acquisition/file_numbers.h"
#include "acquisition/tiff_probe.h"

namespace vsfind {
namespace {

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

constexpr std::ptrdiff_t png_signature = 8;
constexpr std::uint64_t png_chunk_overhead = 12;  // length, type, check sum

/// Every chunk whole with its check sum right, from IHDR to IEND.
ImageProbe probe_png(std::span<const std::byte> bytes) {
  const FileNumbers file(bytes, false);
  ImageProbe probe{ImageFormat::png};
  for (std::uint64_t at = png_signature;;) {
    const std::uint64_t length = file.number(at, 4);
    if (at + png_chunk_overhead + length > file.size()) throw IoError("is cut off");
    const std::string_view type = text_of(bytes.subspan(at + 4, 4));
    const auto* checked = reinterpret_cast<const Bytef*>(bytes.data() + at + 4);
    if (crc32_z(crc32_z(0, nullptr, 0), checked, length + 4) != file.number(at + 8 + length, 4))
      throw IoError(fmt::format("is damaged: wrong check sum at byte {}", at));
    if (at == png_signature) {
      if (type != "IHDR" || length != 13) throw IoError("is damaged: the PNG header is missing");
      probe.width = static_cast<std::int64_t>(file.number(at + 8, 4));
      probe.height = static_cast<std::int64_t>(file.number(at + 12, 4));
    }
    if (type == "IEND") return probe;
    at += png_chunk_overhead + length;
  }
}

/// The frame header, and an end marker somewhere behind it.
ImageProbe probe_jpeg(std::span<const std::byte> bytes) {
  const FileNumbers file(bytes, false);
  ImageProbe probe{ImageFormat::jpeg};
  for (std::uint64_t at = 2;;) {
    if (file.number(at, 1) != 0xff) throw IoError(fmt::format("is damaged: no JPEG marker at byte {}", at));
    const std::uint64_t marker = file.number(at + 1, 1);
    const bool fill = marker == 0xff;
    const bool alone = marker == 0x01 || (marker >= 0xd0 && marker <= 0xd8);
    const bool frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (marker == 0xd9 || marker == 0xda) throw IoError("is damaged: the JPEG frame header is missing");
    if (frame) {
      probe.height = static_cast<std::int64_t>(file.number(at + 5, 2));
      probe.width = static_cast<std::int64_t>(file.number(at + 7, 2));
      if (text_of(bytes.subspan(at)).rfind("\xff\xd9") == std::string_view::npos) throw IoError("is cut off");
      return probe;
    }
    at += fill ? 1 : alone ? 2 : 2 + file.number(at + 2, 2);
  }
}

ImageProbe probe_bmp(std::span<const std::byte> bytes) {
  const FileNumbers file(bytes, true);
  ImageProbe probe{ImageFormat::bmp};
  const std::uint64_t offset = file.number(10, 4);
  const std::uint64_t header = file.number(14, 4);
  std::uint64_t bits = 0;
  std::uint64_t compression = 0;
  if (header == 12) {
    probe.width = static_cast<std::int64_t>(file.number(18, 2));
    probe.height = static_cast<std::int64_t>(file.number(20, 2));
    bits = file.number(24, 2);
  } else {
    probe.width = static_cast<std::int32_t>(file.number(18, 4));
    const std::int64_t height = static_cast<std::int32_t>(file.number(22, 4));  // negative: top row first
    probe.height = std::max(height, -height);
    bits = file.number(28, 2);
    compression = file.number(30, 4);
  }
  if (compression > 3) throw IoError(fmt::format("is a BMP of compression {}: allowed are 0 to 3", compression));
  const bool packed = compression == 1 || compression == 2;
  if (probe.width < 1 || packed) return probe;
  const std::uint64_t row = (static_cast<std::uint64_t>(probe.width) * bits + 31) / 32 * 4;
  if (offset > file.size() ||
      (file.size() - offset) / std::max<std::uint64_t>(row, 1) < static_cast<std::uint64_t>(probe.height))
    throw IoError("is cut off");
  return probe;
}

/// The words of a PNM header: between white space, comments left out.
class PnmWords {
 public:
  explicit PnmWords(std::string_view text) : text_(text) {}
  [[nodiscard]] std::int64_t number() {
    while (at_ < text_.size() && (is_space(text_[at_]) || text_[at_] == '#')) {
      if (text_[at_] == '#') at_ = std::min(text_.find('\n', at_), text_.size() - 1);
      ++at_;
    }
    std::int64_t value = -1;
    for (; at_ < text_.size() && text_[at_] >= '0' && text_[at_] <= '9'; ++at_)
      value = std::min<std::int64_t>(std::max<std::int64_t>(value, 0) * 10 + (text_[at_] - '0'), 1'000'000'000);
    if (value < 0) throw IoError(at_ >= text_.size() ? "is cut off" : "is damaged: a number is missing in its header");
    return value;
  }
  [[nodiscard]] std::string_view rest() const { return text_.substr(at_); }
  static bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

 private:
  std::string_view text_;
  std::size_t at_ = 2;
};

ImageProbe probe_pnm(std::span<const std::byte> bytes) {
  const std::string_view text = text_of(bytes);
  const char kind = text[1];
  const bool bitmap = kind == '1' || kind == '4';
  const bool plain = kind <= '3';
  PnmWords words(text);
  ImageProbe probe{ImageFormat::pnm};
  probe.width = words.number();
  probe.height = words.number();
  const std::int64_t maximum = bitmap ? 1 : words.number();
  if (maximum < 1 || maximum > 65535)
    throw IoError(fmt::format("is damaged: its maximum is {}, allowed are 1 to 65535", maximum));
  probe.maximum = static_cast<int>(maximum);
  const std::int64_t samples = probe.width * (kind == '3' || kind == '6' ? 3 : 1);
  const std::int64_t row = kind == '4' ? (samples + 7) / 8 : samples * (!plain && maximum > 255 ? 2 : 1);
  // One byte of white space ends the header; plain samples are at least a digit each, with a separator but in P1.
  const auto there = static_cast<std::int64_t>(words.rest().size()) - (plain ? 0 : 1);
  if (row > 0 && there / row < probe.height) throw IoError("is cut off");
  if (plain && row > 0) {
    std::int64_t found = 0;
    char before = ' ';
    for (const char c : words.rest()) {
      const bool digit = c >= '0' && c <= '9';
      if (digit && (bitmap || before < '0' || before > '9')) ++found;
      before = c;
    }
    if (found / row < probe.height) throw IoError("is cut off");
  }
  return probe;
}

}  // namespace

ImageProbe probe_image(std::span<const std::byte> bytes) {
  const std::string_view text = text_of(bytes);
  using namespace std::string_view_literals;
  ImageProbe probe;
  if (text.empty()) throw IoError("is empty");
  if (text.starts_with("\x89PNG\r\n\x1a\n"sv)) {
    probe = probe_png(bytes);
  } else if (text.starts_with("\xff\xd8\xff"sv)) {
    probe = probe_jpeg(bytes);
  } else if (text.starts_with("BM"sv)) {
    probe = probe_bmp(bytes);
  } else if (text.starts_with("II*\0"sv) || text.starts_with("MM\0*"sv) || text.starts_with("II+\0"sv) ||
             text.starts_with("MM\0+"sv)) {
    probe = probe_tiff(bytes);
  } else if (text.size() > 2 && text[0] == 'P' && text[1] >= '1' && text[1] <= '6' && PnmWords::is_space(text[2])) {
    probe = probe_pnm(bytes);
  } else {
    throw IoError("is no image that can be read: PNG, JPEG, TIFF, BMP and PNM (PGM, PPM, PBM) can");
  }
  if (probe.width < 1 || probe.height < 1)
    throw IoError(fmt::format("is damaged: its size is {}x{} pixels", probe.width, probe.height));
  return probe;
}

std::vector<std::byte> png_pixels_only(std::span<const std::byte> png) {
  const FileNumbers file(png, false);
  std::vector<std::byte> kept(png.begin(), png.begin() + png_signature);
  kept.reserve(png.size());
  for (std::uint64_t at = png_signature; at < png.size();) {
    const std::uint64_t size = png_chunk_overhead + file.number(at, 4);
    const std::string_view type = text_of(png.subspan(at + 4, 4));
    const bool critical = type[0] >= 'A' && type[0] <= 'Z';
    const std::span<const std::byte> chunk = png.subspan(at, size);
    if (critical || type == "tRNS") kept.insert(kept.end(), chunk.begin(), chunk.end());
    if (type == "IEND") break;
    at += size;
  }
  return kept;
}

}  // namespace vsfind
