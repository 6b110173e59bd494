/// Recordings go to ffmpeg and come from it with identical pixels: the real program, run here.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "acquisition/recording.h"
#include "tests/acquisition/support.h"

namespace vsfind {
namespace {

using test::Picture;

class Ffmpeg : public testing::Test {
 protected:
  void SetUp() override {
    if (std::system("ffmpeg -version >/dev/null 2>&1") != 0) GTEST_SKIP() << "there is no ffmpeg";
  }

  /// Runs ffmpeg in the temporary folder; what it says must be nothing.
  void run(const std::string& arguments) {
    const std::string command =
        "cd '" + folder_.path() + "' && ffmpeg -nostdin -v warning -y " + arguments + " >said 2>&1";
    EXPECT_EQ(std::system(command.c_str()), 0) << command << "\n" << test::read_bytes(folder_.file("said"));
  }
  [[nodiscard]] std::string said() const { return test::read_bytes(folder_.file("said")); }

  test::TemporaryFolder folder_;
};

/// The frames' pixels one after the other, as ffmpeg's rawvideo has them.
std::string raw_pixels(const std::string& path) {
  std::string pixels;
  const auto source = open_y4m(path);
  while (const auto frame = source->next()) {
    const ImageView& image = frame->image();
    for (int y = 0; y < image.height; ++y)
      pixels.append(reinterpret_cast<const char*>(image.data + y * image.stride),
                    static_cast<std::size_t>(image.width * image.bytes_per_pixel()));
  }
  return pixels;
}

class FfmpegReads : public Ffmpeg, public testing::WithParamInterface<std::pair<int, const char*>> {};
INSTANTIATE_TEST_SUITE_P(, FfmpegReads,
                         testing::Values(std::pair{8, "gray"}, std::pair{9, "gray9le"}, std::pair{10, "gray10le"},
                                         std::pair{12, "gray12le"}, std::pair{16, "gray16le"}),
                         [](const auto& tested) { return std::string(tested.param.second); });

TEST_P(FfmpegReads, WhatWeWrite) {
  const auto& [bits, format] = GetParam();
  SourceInfo info;
  info.width = 63;
  info.height = 47;
  info.bits = bits;
  info.order = FieldOrder::top_first;
  info.pixel_aspect = {59, 54};
  info.frame_rate = {25, 1};
  RecordingWriter writer(folder_.file("a.y4m"), info);
  for (std::uint32_t i = 0; i < 5; ++i) {
    FrameInfo frame;
    frame.sequence = i * 1000;
    frame.timestamp_ns = -5 + i;
    frame.clock = Clock::device;
    writer.append(Picture(63, 47, bits, i).view(), frame);
  }
  writer.close();

  // Its own conversions are kept out: the pixel format asked for is the one that it must find.
  run("-i a.y4m -f rawvideo a.raw");
  EXPECT_EQ(said(), "");
  const std::string pixels = raw_pixels(folder_.file("a.y4m"));
  ASSERT_EQ(pixels.size(), 5U * 63U * 47U * (bits > 8 ? 2U : 1U));
  EXPECT_TRUE(test::read_bytes(folder_.file("a.raw")) == pixels) << "the pixels differ";

  run("-i a.y4m -f null -v info -");
  EXPECT_THAT(said(), testing::HasSubstr(format));
  EXPECT_THAT(said(), testing::HasSubstr("top first"));
  EXPECT_THAT(said(), testing::HasSubstr("SAR 59:54"));
  EXPECT_THAT(said(), testing::HasSubstr("25 fps"));
}

struct Written {
  const char* format;
  int bits;
};
class FfmpegWrites : public Ffmpeg, public testing::WithParamInterface<Written> {};
INSTANTIATE_TEST_SUITE_P(, FfmpegWrites,
                         testing::Values(Written{"gray", 8}, Written{"gray9le", 9}, Written{"gray10le", 10},
                                         Written{"gray12le", 12}, Written{"gray16le", 16}, Written{"yuv420p", 8},
                                         Written{"yuvj420p", 8}, Written{"yuv422p", 8}, Written{"yuv444p", 8},
                                         Written{"yuv411p", 8}, Written{"yuv420p9le", 9}, Written{"yuv422p10le", 10},
                                         Written{"yuv444p12le", 12}, Written{"yuv420p14le", 14},
                                         Written{"yuv422p16le", 16}),
                         [](const auto& tested) { return std::string(tested.param.format); });

TEST_P(FfmpegWrites, WhatWeRead) {
  const auto& [format, bits] = GetParam();
  // Odd sizes, so that the chroma's halves are rounded. But of deep pixels ffmpeg 5.1 halves the bytes of a row instead
  // of its pixels, and cannot read its own odd widths.
  const int width = bits > 8 ? 76 : 75;
  run(
      fmt::format("-f lavfi -i testsrc2=size=80x60:rate=50 -vf format=rgb24,crop={}:51 -frames:v 4 -strict -1 -pix_fmt "
                  "{} a.y4m",
                  width, format));
  // The same frames' luma by ffmpeg itself.
  run("-i a.y4m -vf extractplanes=y -f rawvideo a.raw");
  const auto source = open_y4m(folder_.file("a.y4m"));
  EXPECT_EQ(source->info().width, width);
  EXPECT_EQ(source->info().height, 51);
  EXPECT_EQ(source->info().bits, bits);
  EXPECT_EQ(source->info().frames, 4U);
  EXPECT_EQ(source->info().frame_rate.value(), 50.0);
  EXPECT_EQ(source->info().order, FieldOrder::progressive);
  const std::string pixels = raw_pixels(folder_.file("a.y4m"));
  ASSERT_EQ(pixels.size(), 4U * static_cast<std::size_t>(width) * 51U * (bits > 8 ? 2U : 1U));
  EXPECT_TRUE(test::read_bytes(folder_.file("a.raw")) == pixels) << "the pixels differ";
}

TEST_F(Ffmpeg, TellsTheFieldOrder) {
  const std::string input = "-f lavfi -i testsrc2=size=64x48:rate=25 -frames:v 2 -pix_fmt yuv420p ";
  run(input + "-vf setfield=tff -flags +ildct -field_order tt t.y4m");
  run(input + "-vf setfield=bff -flags +ildct -field_order bb b.y4m");
  run(input + "-vf setsar=10/11 p.y4m");
  EXPECT_EQ(open_y4m(folder_.file("t.y4m"))->info().order, FieldOrder::top_first);
  EXPECT_EQ(open_y4m(folder_.file("b.y4m"))->info().order, FieldOrder::bottom_first);
  EXPECT_EQ(open_y4m(folder_.file("p.y4m"))->info().order, FieldOrder::progressive);
  EXPECT_DOUBLE_EQ(open_y4m(folder_.file("p.y4m"))->info().pixel_aspect.value(), 10.0 / 11.0);
}

}  // namespace
}  // namespace vsfind
