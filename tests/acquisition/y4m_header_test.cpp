#include "acquisition/y4m_header.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <string>

#include "acquisition/errors.h"
#include "tests/acquisition/support.h"

namespace vsfind {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

std::string refusal(std::string_view line) {
  return test::complaint<IoError>([&] { static_cast<void>(parse_y4m_header(line)); });
}

TEST(Y4mHeader, ReadsEveryParameter) {
  const Y4mHeader header = parse_y4m_header("YUV4MPEG2 W720 H576 F25:1 Ib A59:54 Cmono10 XYSCSS=MONO Z9");
  EXPECT_EQ(header.width, 720);
  EXPECT_EQ(header.height, 576);
  EXPECT_EQ(header.bits, 10);
  EXPECT_EQ(header.order, FieldOrder::bottom_first);
  EXPECT_DOUBLE_EQ(header.pixel_aspect.value(), 59.0 / 54.0);
  EXPECT_EQ(header.frame_rate.value(), 25.0);
  EXPECT_EQ(header.luma_bytes, 720U * 576U * 2U);
  EXPECT_EQ(header.chroma_bytes, 0U);
}

TEST(Y4mHeader, TakesWhatIsMissingForUnknown) {
  const Y4mHeader header = parse_y4m_header("YUV4MPEG2 W5 H3");
  EXPECT_EQ(header.order, FieldOrder::unknown);
  EXPECT_FALSE(header.pixel_aspect.known());
  EXPECT_FALSE(header.frame_rate.known());
  EXPECT_EQ(header.luma_bytes, 15U);
  EXPECT_EQ(header.chroma_bytes, 12U);  // 4:2:0, halves rounded up
  EXPECT_FALSE(parse_y4m_header("YUV4MPEG2 W5 H3 F0:0 A0:0").frame_rate.known());
  EXPECT_FALSE(parse_y4m_header("YUV4MPEG2 W5 H3 F0:1 A1:0").pixel_aspect.known());
}

TEST(Y4mHeader, ReadsTheFieldOrder) {
  const auto order = [](const std::string& letter) { return parse_y4m_header("YUV4MPEG2 W8 H8 I" + letter).order; };
  EXPECT_EQ(order("p"), FieldOrder::progressive);
  EXPECT_EQ(order("t"), FieldOrder::top_first);
  EXPECT_EQ(order("b"), FieldOrder::bottom_first);
  EXPECT_EQ(order("?"), FieldOrder::unknown);
  EXPECT_EQ(order("m"), FieldOrder::unknown);
  EXPECT_TRUE(parse_y4m_header("YUV4MPEG2 W8 H8 Im").mixed);
  EXPECT_FALSE(parse_y4m_header("YUV4MPEG2 W8 H8 It").mixed);
}

TEST(Y4mHeader, KnowsHowLargeTheChromaIs) {
  struct Case {
    const char* name;
    int bits;
    std::size_t chroma;
  };
  // 7x5 pixels: columns 7, halves 4, quarters 2; rows 5, halves 3, quarters 2.
  for (const auto& [name, bits, chroma] : std::initializer_list<Case>{{"mono", 8, 0},
                                                                      {"mono9", 9, 0},
                                                                      {"mono11", 11, 0},
                                                                      {"mono16", 16, 0},
                                                                      {"420", 8, 24},
                                                                      {"420jpeg", 8, 24},
                                                                      {"420mpeg2", 8, 24},
                                                                      {"420paldv", 8, 24},
                                                                      {"422", 8, 40},
                                                                      {"444", 8, 70},
                                                                      {"444alpha", 8, 105},
                                                                      {"440", 8, 42},
                                                                      {"411", 8, 20},
                                                                      {"410", 8, 8},
                                                                      {"420p10", 10, 48},
                                                                      {"422p12", 12, 80},
                                                                      {"444p9", 9, 140},
                                                                      {"420p14", 14, 48},
                                                                      {"444p16", 16, 140}}) {
    const Y4mHeader header = parse_y4m_header(std::string("YUV4MPEG2 W7 H5 C") + name);
    EXPECT_EQ(header.bits, bits) << name;
    EXPECT_EQ(header.luma_bytes, bits > 8 ? 70U : 35U) << name;
    EXPECT_EQ(header.chroma_bytes, chroma) << name;
  }
}

TEST(Y4mHeader, RefusesWhatItCannotMean) {
  EXPECT_THAT(refusal("YUV4MPEG3 W8 H8"), HasSubstr("not a YUV4MPEG2 recording"));
  EXPECT_THAT(refusal(" YUV4MPEG2 W8 H8"), HasSubstr("not a YUV4MPEG2 recording"));
  EXPECT_THAT(refusal(""), HasSubstr("not a YUV4MPEG2 recording"));
  EXPECT_THAT(refusal("YUV4MPEG2"), HasSubstr("no width"));
  EXPECT_THAT(refusal("YUV4MPEG2 W8"), HasSubstr("no height"));
  EXPECT_THAT(refusal("YUV4MPEG2 W0 H8"), AllOf(HasSubstr("width '0'"), HasSubstr("1 to 65536")));
  EXPECT_THAT(refusal("YUV4MPEG2 W-8 H8"), HasSubstr("width '-8'"));
  EXPECT_THAT(refusal("YUV4MPEG2 W8 H65537"), HasSubstr("height '65537'"));
  EXPECT_THAT(refusal("YUV4MPEG2 W8 H99999999999999999999999"), HasSubstr("height"));
  EXPECT_THAT(refusal("YUV4MPEG2 W8x H8"), HasSubstr("width '8x'"));
  EXPECT_THAT(refusal("YUV4MPEG2 W H8"), HasSubstr("width ''"));
  EXPECT_THAT(refusal("YUV4MPEG2 W65536 H65536"), HasSubstr("too large"));
  EXPECT_EQ(refusal("YUV4MPEG2 W65536 H16384 Cmono16"), "");
  EXPECT_THAT(refusal("YUV4MPEG2 W65536 H16385"), HasSubstr("too large"));
  EXPECT_THAT(refusal("YUV4MPEG2 W8 H8 F25"), HasSubstr("frame rate '25'"));
  EXPECT_THAT(refusal("YUV4MPEG2 W8 H8 F-25:1"), HasSubstr("frame rate '-25:1'"));
  EXPECT_THAT(refusal("YUV4MPEG2 W8 H8 A1:9999999999"), HasSubstr("pixel aspect"));
  EXPECT_THAT(refusal("YUV4MPEG2 W8 H8 Ix"), HasSubstr("interlacing 'x'"));
  for (const char* name : {"mono8", "mono17", "mono-9", "mono1x", "420p8", "420p17", "421", "", "444alphap10", "rgb"})
    EXPECT_THAT(refusal(std::string("YUV4MPEG2 W8 H8 C") + name), HasSubstr("unknown colour space")) << name;
}

TEST(Y4mHeader, ComplainsInOneLineOfPrintableText) {
  std::string line = "YUV4MPEG2 W8 H8 C";
  for (int c = 1; c < 256; ++c) line += static_cast<char>(c == ' ' ? 'x' : c);
  const std::string said = refusal(line);
  EXPECT_THAT(said, Not(HasSubstr("\n")));
  EXPECT_THAT(said, HasSubstr("\\x01"));
  EXPECT_LT(said.size(), 500U);
}

TEST(Y4mHeader, ReadsBackWhatIsWritten) {
  for (int bits = 8; bits <= 16; ++bits) {
    for (const FieldOrder order :
         {FieldOrder::progressive, FieldOrder::top_first, FieldOrder::bottom_first, FieldOrder::unknown}) {
      Y4mHeader header;
      header.width = 1000 + bits;
      header.height = 77;
      header.bits = bits;
      header.order = order;
      header.pixel_aspect = {4320, 4739};
      header.frame_rate = {30000, 1001};
      std::string line = format_y4m_header(header);
      ASSERT_EQ(line.back(), '\n');
      line.pop_back();
      const Y4mHeader read = parse_y4m_header(line);
      EXPECT_EQ(read.width, header.width);
      EXPECT_EQ(read.height, header.height);
      EXPECT_EQ(read.bits, bits);
      EXPECT_EQ(read.order, order);
      EXPECT_EQ(read.pixel_aspect.numerator, 4320);
      EXPECT_EQ(read.frame_rate.denominator, 1001);
      EXPECT_EQ(read.chroma_bytes, 0U);
    }
  }
}

TEST(Y4mHeader, IsShortEnoughForOtherProgramsAtItsLongest) {
  Y4mHeader header;
  header.width = 65536;
  header.height = 16384;
  header.bits = 16;
  header.frame_rate = {std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::max() - 1};
  header.pixel_aspect = header.frame_rate;
  const std::string line = format_y4m_header(header);
  EXPECT_LE(line.size(), 95U);
  EXPECT_NEAR(parse_y4m_header(std::string_view(line).substr(0, line.size() - 1)).frame_rate.value(), 1.0, 1e-6);
}

TEST(Y4mFrameLine, ReadsTheOrderOfMixedRecordings) {
  const auto order = [](std::string_view line) { return parse_y4m_frame_line(line).order; };
  EXPECT_FALSE(order("FRAME").has_value());
  EXPECT_EQ(order("FRAME Itii"), FieldOrder::top_first);
  EXPECT_EQ(order("FRAME ITi?"), FieldOrder::top_first);
  EXPECT_EQ(order("FRAME Ibii"), FieldOrder::bottom_first);
  EXPECT_EQ(order("FRAME Itpp"), FieldOrder::progressive);
  EXPECT_EQ(order("FRAME I1pp"), FieldOrder::progressive);
  EXPECT_EQ(order("FRAME I"), FieldOrder::unknown);
  EXPECT_FALSE(parse_y4m_frame_line("FRAME XOTHER=1 Xvsfind=2").tag.has_value());
}

TEST(Y4mFrameLine, ReadsBackEveryTag) {
  for (const std::uint64_t sequence :
       {std::uint64_t{0}, std::uint64_t{65536}, std::numeric_limits<std::uint64_t>::max()}) {
    for (const std::int64_t time : {std::numeric_limits<std::int64_t>::min(), std::int64_t{-1}, std::int64_t{0},
                                    std::int64_t{1'234'567'890'123}, std::numeric_limits<std::int64_t>::max()}) {
      for (int code = 0; code < 5 * 3 * 3 * 4 * 2 * 3; ++code) {
        Y4mTag tag{sequence,
                   time,
                   static_cast<Clock>(code % 5),
                   static_cast<FrameStatus>(code / 5 % 3),
                   static_cast<Field>(code / 15 % 3),
                   static_cast<FieldOrder>(code / 45 % 4),
                   code / 180 % 2 == 1,
                   static_cast<StampedAt>(code / 360)};
        const std::string line = format_y4m_frame_line(tag);
        ASSERT_EQ(line.size(), 63U);  // always as long, and below the 80 bytes of other readers
        const auto read = parse_y4m_frame_line(std::string_view(line).substr(0, line.size() - 1)).tag;
        ASSERT_TRUE(read.has_value());
        EXPECT_EQ(read->sequence, sequence);
        EXPECT_EQ(read->timestamp_ns, time);
        EXPECT_EQ(read->clock, tag.clock);
        EXPECT_EQ(read->status, tag.status);
        EXPECT_EQ(read->field, tag.field);
        EXPECT_EQ(read->order, tag.order);
        EXPECT_EQ(read->empty, tag.empty);
        EXPECT_EQ(read->stamped_at, tag.stamped_at);
      }
    }
  }
}

TEST(Y4mFrameLine, RefusesDamage) {
  const auto said = [](std::string_view line) {
    return test::complaint<IoError>([&] { static_cast<void>(parse_y4m_frame_line(line)); });
  };
  EXPECT_THAT(said("FRAM"), HasSubstr("not with 'FRAME'"));
  EXPECT_THAT(said("FRAMES"), HasSubstr("not with 'FRAME'"));
  EXPECT_THAT(said(""), HasSubstr("not with 'FRAME'"));
  for (const char* tag : {"", "1", "1,2", "1,2,", "1,2,mgfp", "1,2,mgfpz", "1,2,zgfpi", "1,x,mgfpi", "-1,2,mgfpi",
                          "1,99999999999999999999,mgfpi", "99999999999999999999,2,mgfpi", "1,++2,mgfpi"})
    EXPECT_THAT(said(std::string("FRAME XVSFIND=") + tag), HasSubstr("bad parameter")) << tag;
  EXPECT_EQ(said("FRAME XVSFIND=1,2,mgfpi,of a later version"), "");
  EXPECT_EQ(parse_y4m_frame_line("FRAME XVSFIND=1,2,mgfpi").tag->stamped_at, StampedAt::unknown);
}

TEST(Y4mHeader, WithstandsRandomBytes) {
  std::mt19937 random(1);
  const std::string seed = "YUV4MPEG2 W720 H576 F25:1 Ib A59:54 Cmono10 XYSCSS=MONO";
  const std::string frame = "FRAME Itii XVSFIND=00000000000000000012,+0000000000000000007,mgfpi";
  int accepted = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string line = i % 2 == 0 ? seed : frame;
    for (int n = static_cast<int>(random() % 4); n >= 0; --n)
      line[random() % line.size()] = static_cast<char>(random());
    if (random() % 4 == 0) line.resize(random() % line.size());
    try {
      if (i % 2 == 0) {
        const Y4mHeader header = parse_y4m_header(line);
        EXPECT_LE(header.luma_bytes, std::size_t{1} << 31U);
        EXPECT_LE(header.chroma_bytes, 3 * (std::size_t{1} << 31U));
      } else {
        static_cast<void>(parse_y4m_frame_line(line));
      }
      ++accepted;
    } catch (const IoError&) {
    }
  }
  EXPECT_GT(accepted, 100);
  EXPECT_LT(accepted, 19000);
}

}  // namespace
}  // namespace vsfind
