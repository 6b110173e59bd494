#include "acquisition/gige_pixels.h"

#include <array>
#include <cstring>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace vsfind {
namespace {

using Colour = GigePixels::Colour;
using Packing = GigePixels::Packing;

struct Entry {
  std::uint32_t format;
  const char* name;
  GigePixels pixels;
};

// PFNC 2.4 and the older names of GigE Vision 1.
constexpr std::array formats{
    Entry{0x01080001, "Mono8", {8, Packing::plain, Colour::mono}},
    Entry{0x01100003, "Mono10", {10, Packing::plain, Colour::mono}},
    Entry{0x010C0004, "Mono10Packed", {10, Packing::packed, Colour::mono}},
    Entry{0x010A0046, "Mono10p", {10, Packing::dense, Colour::mono}},
    Entry{0x01100005, "Mono12", {12, Packing::plain, Colour::mono}},
    Entry{0x010C0006, "Mono12Packed", {12, Packing::packed, Colour::mono}},
    Entry{0x010C0047, "Mono12p", {12, Packing::dense, Colour::mono}},
    Entry{0x01100025, "Mono14", {14, Packing::plain, Colour::mono}},
    Entry{0x010E0104, "Mono14p", {14, Packing::dense, Colour::mono}},
    Entry{0x01100007, "Mono16", {16, Packing::plain, Colour::mono}},
    Entry{0x01080008, "BayerGR8", {8, Packing::plain, Colour::bayer_gr}},
    Entry{0x01080009, "BayerRG8", {8, Packing::plain, Colour::bayer_rg}},
    Entry{0x0108000A, "BayerGB8", {8, Packing::plain, Colour::bayer_gb}},
    Entry{0x0108000B, "BayerBG8", {8, Packing::plain, Colour::bayer_bg}},
    Entry{0x0110000C, "BayerGR10", {10, Packing::plain, Colour::bayer_gr}},
    Entry{0x0110000D, "BayerRG10", {10, Packing::plain, Colour::bayer_rg}},
    Entry{0x0110000E, "BayerGB10", {10, Packing::plain, Colour::bayer_gb}},
    Entry{0x0110000F, "BayerBG10", {10, Packing::plain, Colour::bayer_bg}},
    Entry{0x01100010, "BayerGR12", {12, Packing::plain, Colour::bayer_gr}},
    Entry{0x01100011, "BayerRG12", {12, Packing::plain, Colour::bayer_rg}},
    Entry{0x01100012, "BayerGB12", {12, Packing::plain, Colour::bayer_gb}},
    Entry{0x01100013, "BayerBG12", {12, Packing::plain, Colour::bayer_bg}},
    Entry{0x0110002E, "BayerGR16", {16, Packing::plain, Colour::bayer_gr}},
    Entry{0x0110002F, "BayerRG16", {16, Packing::plain, Colour::bayer_rg}},
    Entry{0x01100030, "BayerGB16", {16, Packing::plain, Colour::bayer_gb}},
    Entry{0x01100031, "BayerBG16", {16, Packing::plain, Colour::bayer_bg}},
    Entry{0x010C0026, "BayerGR10Packed", {10, Packing::packed, Colour::bayer_gr}},
    Entry{0x010C0027, "BayerRG10Packed", {10, Packing::packed, Colour::bayer_rg}},
    Entry{0x010C0028, "BayerGB10Packed", {10, Packing::packed, Colour::bayer_gb}},
    Entry{0x010C0029, "BayerBG10Packed", {10, Packing::packed, Colour::bayer_bg}},
    Entry{0x010C002A, "BayerGR12Packed", {12, Packing::packed, Colour::bayer_gr}},
    Entry{0x010C002B, "BayerRG12Packed", {12, Packing::packed, Colour::bayer_rg}},
    Entry{0x010C002C, "BayerGB12Packed", {12, Packing::packed, Colour::bayer_gb}},
    Entry{0x010C002D, "BayerBG12Packed", {12, Packing::packed, Colour::bayer_bg}},
    Entry{0x010A0056, "BayerGR10p", {10, Packing::dense, Colour::bayer_gr}},
    Entry{0x010A0058, "BayerRG10p", {10, Packing::dense, Colour::bayer_rg}},
    Entry{0x010A0054, "BayerGB10p", {10, Packing::dense, Colour::bayer_gb}},
    Entry{0x010A0052, "BayerBG10p", {10, Packing::dense, Colour::bayer_bg}},
    Entry{0x010C0057, "BayerGR12p", {12, Packing::dense, Colour::bayer_gr}},
    Entry{0x010C0059, "BayerRG12p", {12, Packing::dense, Colour::bayer_rg}},
    Entry{0x010C0055, "BayerGB12p", {12, Packing::dense, Colour::bayer_gb}},
    Entry{0x010C0053, "BayerBG12p", {12, Packing::dense, Colour::bayer_bg}},
    Entry{0x02180014, "RGB8", {8, Packing::plain, Colour::rgb}},
    Entry{0x02180015, "BGR8", {8, Packing::plain, Colour::bgr}},
    Entry{0x02200016, "RGBa8", {8, Packing::plain, Colour::rgba}},
    Entry{0x02200017, "BGRa8", {8, Packing::plain, Colour::bgra}},
    Entry{0x02300018, "RGB10", {10, Packing::plain, Colour::rgb}},
    Entry{0x02300019, "BGR10", {10, Packing::plain, Colour::bgr}},
    Entry{0x0230001A, "RGB12", {12, Packing::plain, Colour::rgb}},
    Entry{0x0230001B, "BGR12", {12, Packing::plain, Colour::bgr}},
    Entry{0x02300033, "RGB16", {16, Packing::plain, Colour::rgb}},
    Entry{0x0230004B, "BGR16", {16, Packing::plain, Colour::bgr}},
    Entry{0x020C001E, "YUV411_8_UYYVYY", {8, Packing::plain, Colour::uyyvyy}},
    Entry{0x0210001F, "YUV422_8_UYVY", {8, Packing::plain, Colour::luma_second}},
    Entry{0x02100032, "YUV422_8", {8, Packing::plain, Colour::luma_first}},
    Entry{0x0210003B, "YCbCr422_8", {8, Packing::plain, Colour::luma_first}},
    Entry{0x02100043, "YCbCr422_8_CbYCrY", {8, Packing::plain, Colour::luma_second}},
};

const Entry* entry_of(std::uint32_t format) {
  for (const Entry& entry : formats) {
    if (entry.format == format) return &entry;
  }
  return nullptr;
}

int channels(Colour colour) {
  switch (colour) {
    case Colour::rgb:
    case Colour::bgr:
      return 3;
    case Colour::rgba:
    case Colour::bgra:
      return 4;
    case Colour::luma_first:
    case Colour::luma_second:
      return 2;
    default:
      return 1;
  }
}

/// OpenCV's conversion to grey, where there is one.
std::optional<int> conversion(Colour colour) {
  switch (colour) {
    case Colour::bayer_rg:
      return cv::COLOR_BayerRGGB2GRAY;
    case Colour::bayer_gr:
      return cv::COLOR_BayerGRBG2GRAY;
    case Colour::bayer_gb:
      return cv::COLOR_BayerGBRG2GRAY;
    case Colour::bayer_bg:
      return cv::COLOR_BayerBGGR2GRAY;
    case Colour::rgb:
      return cv::COLOR_RGB2GRAY;
    case Colour::bgr:
      return cv::COLOR_BGR2GRAY;
    case Colour::rgba:
      return cv::COLOR_RGBA2GRAY;
    case Colour::bgra:
      return cv::COLOR_BGRA2GRAY;
    default:
      return std::nullopt;
  }
}

/// Pixels follow each other without regard to rows.
void unpack(const GigePixels& pixels, const std::byte* from, std::size_t count, std::uint16_t* to) {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(from);
  const auto bits = static_cast<unsigned>(pixels.bits);
  if (pixels.packing == Packing::packed) {
    const unsigned low = bits - 8;
    const unsigned mask = (1U << low) - 1U;
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint8_t* const triple = bytes + i / 2 * 3;
      const unsigned high = triple[i % 2 == 0 ? 0 : 2];
      to[i] = static_cast<std::uint16_t>(high << low | (triple[1] >> (i % 2 == 0 ? 0U : 4U) & mask));
    }
    return;
  }
  const std::uint32_t mask = (1U << bits) - 1U;
  const std::size_t size = (count * bits + 7) / 8;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t bit = i * bits;
    const std::size_t byte = bit / 8;
    std::uint32_t word = 0;  // a sample of up to 16 bits lies in three bytes at most
    for (std::size_t k = 0; k < 3 && byte + k < size; ++k) word |= std::uint32_t{bytes[byte + k]} << (8 * k);
    to[i] = static_cast<std::uint16_t>(word >> (bit % 8) & mask);
  }
}

void pick_luma(Colour colour, const std::uint8_t* from, int width, std::uint8_t* to) {
  if (colour == Colour::uyyvyy) {
    constexpr std::array places{1, 2, 4, 5};  // of four pixels in six bytes
    for (int x = 0; x < width; ++x) to[x] = from[x / 4 * 6 + places[static_cast<std::size_t>(x % 4)]];
    return;
  }
  const int first = colour == Colour::luma_second ? 1 : 0;
  for (int x = 0; x < width; ++x) to[x] = from[2 * x + first];
}

}  // namespace

std::optional<GigePixels> gige_pixels(std::uint32_t format) {
  const Entry* const entry = entry_of(format);
  return entry != nullptr ? std::optional(entry->pixels) : std::nullopt;
}

std::string gige_pixel_format_name(std::uint32_t format) {
  const Entry* const entry = entry_of(format);
  return entry != nullptr ? entry->name : "";
}

std::size_t GigePixels::bytes(int width, int height) const {
  const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  if (packing == Packing::packed) return (count * 3 + 1) / 2;
  if (packing == Packing::dense) return (count * static_cast<std::size_t>(bits) + 7) / 8;
  if (colour == Colour::uyyvyy) return static_cast<std::size_t>((width + 3) / 4 * 6) * static_cast<std::size_t>(height);
  return count * static_cast<std::size_t>(channels(colour)) * (bits > 8 ? 2U : 1U);
}

ImageView luma_from_gige(const GigePixels& pixels, const std::byte* from, int width, int height, std::ptrdiff_t stride,
                         std::byte* to) {
  ImageView view{to, width, height, static_cast<std::ptrdiff_t>(width) * (pixels.bits > 8 ? 2 : 1), pixels.bits};
  std::vector<std::uint16_t> unpacked;
  if (pixels.packing != Packing::plain) {
    const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    if (pixels.colour == Colour::mono) {
      unpack(pixels, from, count, reinterpret_cast<std::uint16_t*>(to));
      return view;
    }
    unpacked.resize(count);
    unpack(pixels, from, count, unpacked.data());
    from = reinterpret_cast<const std::byte*>(unpacked.data());
    stride = 0;
  }
  if (stride == 0) stride = static_cast<std::ptrdiff_t>(pixels.bytes(width, 1));
  if (pixels.packing != Packing::plain) stride = view.stride;
  if (pixels.colour == Colour::mono) {
    for (int y = 0; y < height; ++y)
      std::memcpy(to + y * view.stride, from + y * stride, static_cast<std::size_t>(view.stride));
    return view;
  }
  const std::optional<int> code = conversion(pixels.colour);
  if (!code) {
    for (int y = 0; y < height; ++y)
      pick_luma(pixels.colour, reinterpret_cast<const std::uint8_t*>(from + y * stride), width,
                reinterpret_cast<std::uint8_t*>(to + y * view.stride));
    return view;
  }
  const int depth = pixels.bits > 8 ? CV_16U : CV_8U;
  const cv::Mat colour(height, width, CV_MAKETYPE(depth, channels(pixels.colour)),
                       const_cast<std::byte*>(from),  // not written to
                       static_cast<std::size_t>(stride));
  cv::Mat grey(height, width, CV_MAKETYPE(depth, 1), to, static_cast<std::size_t>(view.stride));
  cv::cvtColor(colour, grey, *code);
  return view;
}

}  // namespace vsfind
