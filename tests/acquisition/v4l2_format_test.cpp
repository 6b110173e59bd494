#include "acquisition/v4l2_format.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/acquisition/support.h"

namespace vsfind {
namespace {

using test::Picture;

std::uint32_t fourcc(const std::string& name) { return fourcc_from_name(name).value(); }

TEST(V4l2Format, NamesAndCodesAreTheSameThing) {
  for (const char* name : {"GREY", "YUYV", "MJPG", "Y10", "Y12", "Y16", "Y16-BE", "NV12", "422P"})
    EXPECT_EQ(fourcc_name(fourcc(name)), name);
  EXPECT_EQ(fourcc("GREY"), 0x59455247U);
  EXPECT_EQ(fourcc("Y16"), 0x20363159U);
  EXPECT_EQ(fourcc("Y16 -BE"), 0xa0363159U) << "as the kernel's documentation writes it";
  for (const char* bad : {"", "GREYS", "-BE", "G\x01", "\xc3\xa9"}) EXPECT_FALSE(fourcc_from_name(bad)) << bad;
  EXPECT_EQ(fourcc_name(0), "????") << "a device may answer anything";
}

/// How a test lays samples down, by its own reading of the format's documentation.
struct Layout {
  const char* name;
  int bits;
  int first;        // bytes before the first sample
  int step;         // bytes from a sample to the next
  bool high_first;  // of two bytes
  double planes;    // of the luma plane's size
};
void PrintTo(const Layout& layout, std::ostream* stream) { *stream << layout.name; }

class LumaOf : public testing::TestWithParam<Layout> {};

INSTANTIATE_TEST_SUITE_P(, LumaOf,
                         testing::Values(Layout{"GREY", 8, 0, 1, false, 1}, Layout{"Y10", 10, 0, 2, false, 1},
                                         Layout{"Y12", 12, 0, 2, false, 1}, Layout{"Y14", 14, 0, 2, false, 1},
                                         Layout{"Y16", 16, 0, 2, false, 1}, Layout{"Y16-BE", 16, 0, 2, true, 1},
                                         Layout{"YUYV", 8, 0, 2, false, 1}, Layout{"YVYU", 8, 0, 2, false, 1},
                                         Layout{"UYVY", 8, 1, 2, false, 1}, Layout{"VYUY", 8, 1, 2, false, 1},
                                         Layout{"NV12", 8, 0, 1, false, 1.5}, Layout{"NV21", 8, 0, 1, false, 1.5},
                                         Layout{"NV16", 8, 0, 1, false, 2}, Layout{"NV24", 8, 0, 1, false, 3},
                                         Layout{"YU12", 8, 0, 1, false, 1.5}, Layout{"YV12", 8, 0, 1, false, 1.5},
                                         Layout{"422P", 8, 0, 1, false, 2}),
                         [](const auto& tested) {
                           std::string name = tested.param.name;
                           for (char& c : name) c = c == '-' ? '_' : c;
                           return name;
                         });

TEST_P(LumaOf, IsReadAsItStandsFromRowsOfAnyLengthAndAlignment) {
  const Layout& given = GetParam();
  const auto layout = luma_layout(fourcc(given.name));
  ASSERT_TRUE(layout);
  EXPECT_EQ(layout->bits, given.bits);
  for (const int width : {2, 16, 34, 66}) {
    for (const int padding : {0, 3}) {
      for (const std::size_t misaligned : {0U, 1U}) {
        constexpr int rows = 5;
        const Picture picture(width, rows, given.bits, 5);
        const int stride = width * given.step + padding;
        // What is not luma is noise.
        std::vector<std::byte> buffer(misaligned + static_cast<std::size_t>(stride * rows), std::byte{0xa5});
        std::byte* data = buffer.data() + misaligned;
        for (int y = 0; y < rows; ++y) {
          for (int x = 0; x < width; ++x) {
            std::byte* sample = data + y * stride + given.first + x * given.step;
            const auto value = static_cast<unsigned>(picture.view().at(x, y));
            sample[given.bits > 8 && given.high_first ? 1 : 0] = static_cast<std::byte>(value & 0xffU);
            if (given.bits > 8) sample[given.high_first ? 0 : 1] = static_cast<std::byte>(value >> 8U);
          }
        }
        const int bytes = given.bits > 8 ? 2 : 1;
        std::vector<std::uint16_t> luma(static_cast<std::size_t>(width * rows));
        auto* target = reinterpret_cast<std::byte*>(luma.data());
        copy_luma(*layout, data, stride, width, rows, target, width * bytes);
        const ImageView view{target, width, rows, width * bytes, given.bits};
        EXPECT_TRUE(test::same_pixels(view, picture.view())) << width << " wide, padding " << padding;
      }
    }
  }
  EXPECT_EQ(picture_bytes(*layout, 640, 480), static_cast<std::size_t>(640 * 480 * given.planes));
}

TEST(V4l2Format, BitsAboveTheSignificantOnesAreCutOff) {
  const std::vector<std::uint8_t> buffer{0x34, 0xf2, 0xff, 0xff};
  std::vector<std::uint16_t> luma(2);
  copy_luma(*luma_layout(fourcc("Y10")), reinterpret_cast<const std::byte*>(buffer.data()), 4, 2, 1,
            reinterpret_cast<std::byte*>(luma.data()), 4);
  EXPECT_EQ(luma[0], 0x234);
  EXPECT_EQ(luma[1], 0x3ff);
}

TEST(V4l2Format, WhatHoldsNoLumaIsNotReadDirectly) {
  for (const char* name : {"RGB3", "BGR3", "BA81", "GRBG", "MJPG", "JPEG", "H264", "RGBP"})
    EXPECT_FALSE(luma_layout(fourcc(name))) << name;
  EXPECT_TRUE(is_jpeg(fourcc("MJPG")));
  EXPECT_TRUE(is_jpeg(fourcc("JPEG")));
  EXPECT_FALSE(is_jpeg(fourcc("GREY")));
}

std::vector<std::byte> bytes(std::initializer_list<int> values) {
  std::vector<std::byte> result;
  for (const int value : values) result.push_back(static_cast<std::byte>(value));
  return result;
}

TEST(V4l2Format, AJpegPictureIsWholeOnlyWithItsEnd) {
  // SOI, a segment with an end marker of a thumbnail in it, a scan with a stuffed 0xff and a restart marker, EOI.
  const auto whole = bytes(
      {0xff, 0xd8, 0xff, 0xe1, 0, 6, 0xff, 0xd9, 1, 2, 0xff, 0xda, 0, 3, 7, 9, 0xff, 0, 5, 0xff, 0xd0, 8, 0xff, 0xd9});
  EXPECT_TRUE(jpeg_is_whole(whole));
  auto padded = whole;
  padded.resize(100);
  EXPECT_TRUE(jpeg_is_whole(padded)) << "padding behind it";
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_FALSE(jpeg_is_whole(std::span(whole).first(size))) << "cut off after " << size << " bytes";
  EXPECT_FALSE(jpeg_is_whole(bytes({0xff, 0xd8, 0xff, 0xe1, 0xff, 0xff, 0, 0}))) << "a segment longer than the picture";
  EXPECT_FALSE(jpeg_is_whole(bytes({0, 0, 0, 0, 0xff, 0xd9})));
}

}  // namespace
}  // namespace vsfind
