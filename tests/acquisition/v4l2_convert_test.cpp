/// Conversions through libv4l2, on buffers made here: no device is needed.

#include "acquisition/v4l2_convert.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <vector>

#include "tests/acquisition/support.h"

namespace vsfind {
namespace {

constexpr int width = 64;
constexpr int height = 48;

v4l2_format format_of(std::uint32_t fourcc, int bytes_per_line) {
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  format.fmt.pix.width = width;
  format.fmt.pix.height = height;
  format.fmt.pix.pixelformat = fourcc;
  format.fmt.pix.field = V4L2_FIELD_NONE;
  format.fmt.pix.bytesperline = static_cast<std::uint32_t>(bytes_per_line);
  format.fmt.pix.sizeimage = static_cast<std::uint32_t>((bytes_per_line > 0 ? bytes_per_line : 4 * width) * height);
  return format;
}

/// A smooth picture in colours.
cv::Vec3b colour(int x, int y) {  // red, green, blue
  return {static_cast<std::uint8_t>(40 + 3 * x), static_cast<std::uint8_t>(20 + 4 * y),
          static_cast<std::uint8_t>(200 - 2 * x)};
}
double grey(int x, int y) {
  const cv::Vec3b c = colour(x, y);
  return 0.299 * c[0] + 0.587 * c[1] + 0.114 * c[2];
}

/// The largest difference of luma from what it should be, `margin` pixels from the border on.
double worst(std::span<const std::byte> luma, int margin) {
  double result = 0.0;
  for (int y = margin; y < height - margin; ++y) {
    for (int x = margin; x < width - margin; ++x)
      result =
          std::max(result, std::abs(static_cast<double>(luma[static_cast<std::size_t>(y * width + x)]) - grey(x, y)));
  }
  return result;
}

TEST(V4l2Convert, RgbBecomesItsLuma) {
  for (const auto fourcc : {V4L2_PIX_FMT_RGB24, V4L2_PIX_FMT_BGR24}) {
    std::vector<std::byte> buffer;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        for (const int channel : {0, 1, 2})
          buffer.push_back(std::byte{colour(x, y)[fourcc == V4L2_PIX_FMT_RGB24 ? channel : 2 - channel]});
      }
    }
    V4l2Converter converter(-1, format_of(fourcc, 3 * width));
    const auto luma = converter.luma(buffer);
    ASSERT_EQ(luma.size(), std::size_t{width * height}) << converter.complaint();
    EXPECT_LE(worst(luma, 0), 0.51) << fourcc_name(fourcc);
  }
}

TEST(V4l2Convert, BayerBecomesLuma) {
  struct Mosaic {
    std::uint32_t fourcc;
    std::array<int, 4> channels;  // of the 2x2 pixels, row by row
  };
  for (const auto& [fourcc, channels] :
       {Mosaic{V4L2_PIX_FMT_SRGGB8, {0, 1, 1, 2}}, Mosaic{V4L2_PIX_FMT_SBGGR8, {2, 1, 1, 0}},
        Mosaic{V4L2_PIX_FMT_SGRBG8, {1, 0, 2, 1}}, Mosaic{V4L2_PIX_FMT_SGBRG8, {1, 2, 0, 1}}}) {
    std::vector<std::byte> buffer;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x)
        buffer.push_back(std::byte{colour(x, y)[channels[static_cast<std::size_t>(2 * (y % 2) + x % 2)]]});
    }
    V4l2Converter converter(-1, format_of(fourcc, width));
    const auto luma = converter.luma(buffer);
    ASSERT_EQ(luma.size(), std::size_t{width * height}) << converter.complaint();
    EXPECT_LE(worst(luma, 2), 4.0) << fourcc_name(fourcc);
  }
}

std::vector<std::byte> jpeg() {
  cv::Mat picture(height, width, CV_8UC3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const cv::Vec3b c = colour(x, y);
      picture.at<cv::Vec3b>(y, x) = {c[2], c[1], c[0]};
    }
  }
  std::vector<std::uint8_t> bytes;
  cv::imencode(".jpg", picture, bytes, {cv::IMWRITE_JPEG_QUALITY, 95});
  const auto* begin = reinterpret_cast<const std::byte*>(bytes.data());
  return {begin, begin + bytes.size()};
}

TEST(V4l2Convert, MotionJpegIsDecoded) {
  for (const auto fourcc : {V4L2_PIX_FMT_MJPEG, V4L2_PIX_FMT_JPEG}) {
    V4l2Converter converter(-1, format_of(fourcc, 0));
    auto picture = jpeg();
    auto luma = converter.luma(picture);
    ASSERT_EQ(luma.size(), std::size_t{width * height}) << converter.complaint();
    EXPECT_LE(worst(luma, 0), 4.0) << fourcc_name(fourcc);
    picture.resize(picture.size() + 500);  // some cameras pad
    EXPECT_FALSE(converter.luma(picture).empty()) << converter.complaint();
  }
}

TEST(V4l2Convert, APictureThatIsCutOffOrDamagedIsToldOf) {
  V4l2Converter converter(-1, format_of(V4L2_PIX_FMT_MJPEG, 0));
  const auto whole = jpeg();
  for (std::size_t size = 0; size < whole.size(); size += 37) {
    EXPECT_TRUE(converter.luma(std::span(whole).first(size)).empty()) << size << " bytes of " << whole.size();
    EXPECT_FALSE(converter.complaint().empty());
  }
  auto other_size = whole;
  for (std::size_t i = 0; i + 8 < other_size.size(); ++i) {
    // The header says another height.
    if (other_size[i] == std::byte{0xff} && other_size[i + 1] == std::byte{0xc0}) other_size[i + 6] = std::byte{32};
  }
  EXPECT_TRUE(converter.luma(other_size).empty());
  EXPECT_FALSE(converter.luma(whole).empty()) << "and the next one is good again: " << converter.complaint();
}

TEST(V4l2Convert, RefusesAFormatThatLibv4l2DoesNotKnow) {
  const std::string complaint =
      test::complaint<std::runtime_error>([] { V4l2Converter converter(-1, format_of(V4L2_PIX_FMT_H264, 0)); });
  EXPECT_THAT(complaint, testing::HasSubstr("H264"));
}

}  // namespace
}  // namespace vsfind
