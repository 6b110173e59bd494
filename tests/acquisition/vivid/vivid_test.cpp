/// Every pixel and every field of what the guest recorded.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "acquisition/weave.h"
#include "tests/acquisition/support.h"
#include "tests/acquisition/vivid/results.h"
#include "tests/acquisition/vivid/shown_frame.h"

namespace vsfind::test {
namespace {

struct Loop {
  const char* name;
  int width;
  int height;
  FieldOrder order;
  bool fields;  // single ones
  Ratio aspect;
  double rate;
  std::size_t frames;
};
void PrintTo(const Loop& loop, std::ostream* stream) { *stream << loop.name; }

class VividLoop : public VividTestWith<Loop> {};

INSTANTIATE_TEST_SUITE_P(
    , VividLoop,
    testing::Values(
        Loop{"loop_pal_interlaced", 720, 576, FieldOrder::top_first, false, {59, 54}, 25, 52},
        Loop{"loop_pal_alternate", 720, 576, FieldOrder::top_first, true, {59, 54}, 25, 52},
        Loop{"loop_pal_interlaced_tb", 720, 576, FieldOrder::top_first, false, {59, 54}, 25, 12},
        Loop{"loop_ntsc_interlaced", 720, 480, FieldOrder::bottom_first, false, {10, 11}, 30e3 / 1001, 12},
        Loop{"loop_ntsc_interlaced_bt", 720, 480, FieldOrder::bottom_first, false, {10, 11}, 30e3 / 1001, 12},
        Loop{"loop_ntsc_alternate", 720, 480, FieldOrder::bottom_first, true, {10, 11}, 30e3 / 1001, 24},
        Loop{"loop_progressive", 640, 480, FieldOrder::progressive, false, {1, 1}, 60, 24}),
    [](const auto& tested) { return std::string(tested.param.name); });

TEST_P(VividLoop, BringsEveryFrameBackByteForByte) {
  const Loop& loop = GetParam();
  ASSERT_EQ(guest_code(loop.name), 0) << guest_text(std::string(loop.name) + ".err");
  const GuestRecording recording = guest_recording(loop.name);
  EXPECT_EQ(recording.info.width, loop.width);
  EXPECT_EQ(recording.info.height, loop.height);
  EXPECT_EQ(recording.info.order, loop.order);
  EXPECT_EQ(recording.info.pixel_aspect.numerator, loop.aspect.numerator);
  EXPECT_EQ(recording.info.pixel_aspect.denominator, loop.aspect.denominator);
  EXPECT_NEAR(recording.info.frame_rate.value(), loop.rate, 0.02 * loop.rate);
  ASSERT_EQ(recording.frames.size(), loop.frames);

  const ShownFrames shown(VIVID_RECORDING, loop.width, loop.height);
  std::vector<std::uint8_t> picture;
  std::set<std::uint32_t> numbers;
  std::uint32_t last_number = 0;
  std::uint64_t last_sequence = 0;
  std::set<Field> fields;
  std::set<std::pair<std::uint64_t, Field>> places;
  for (const Frame& frame : recording.frames) {
    const FrameInfo& info = frame.info();
    ASSERT_EQ(info.status, FrameStatus::good);
    EXPECT_EQ(info.order, loop.order);
    EXPECT_EQ(info.clock, Clock::monotonic);
    EXPECT_EQ(info.field != Field::frame, loop.fields);
    fields.insert(info.field);
    EXPECT_GE(info.sequence, last_sequence);
    last_sequence = info.sequence;
    EXPECT_TRUE(places.emplace(info.sequence, info.field).second) << "two pictures in one place";
    const auto number = shown_number(frame.image());
    ASSERT_TRUE(number) << "frame " << info.sequence << " (" << name(info.field) << ") tells no number";
    EXPECT_GE(*number, last_number) << "frames come in their order";
    last_number = *number;
    numbers.insert(*number);
    shown.draw(*number, picture);
    const ImageView whole{reinterpret_cast<const std::byte*>(picture.data()), loop.width, loop.height, loop.width, 8};
    ASSERT_TRUE(same_pixels(frame.image(), field_view(whole, info.field)))
        << "frame " << info.sequence << " (" << name(info.field) << "), shown as number " << *number;
  }
  EXPECT_EQ(fields, loop.fields ? (std::set<Field>{Field::top, Field::bottom}) : (std::set<Field>{Field::frame}));
  // A slow machine shows a frame several times, but not one only.
  EXPECT_GE(numbers.size(), loop.frames / (loop.fields ? 8 : 4));
}

class VividPattern : public VividTestWith<std::tuple<std::string, std::string, std::string>> {};

INSTANTIATE_TEST_SUITE_P(, VividPattern,
                         testing::Combine(testing::Values("lines", "squares"), testing::Values("PAL", "NTSC"),
                                          testing::Values("interlaced", "interlaced_tb", "interlaced_bt", "seq_tb",
                                                          "seq_bt", "alternate", "top", "bottom")),
                         [](const auto& tested) {
                           return fmt::format("{}_{}_{}", std::get<0>(tested.param), std::get<1>(tested.param),
                                              std::get<2>(tested.param));
                         });

TEST_P(VividPattern, HasItsLinesInTheirPlacesInEveryFieldOrder) {
  const auto& [kind, standard, fields] = GetParam();
  const bool pal = standard == "PAL";
  const std::string step = fmt::format("{}_{}_{}", kind, standard, fields);
  ASSERT_EQ(guest_code(step), 0) << guest_text(step + ".err");
  const GuestRecording recording = guest_recording(step);
  ASSERT_EQ(recording.frames.size(), 2U);
  EXPECT_EQ(recording.info.width, 720);
  EXPECT_EQ(recording.info.height, pal ? 576 : 480);
  const FieldOrder of_standard = pal ? FieldOrder::top_first : FieldOrder::bottom_first;
  EXPECT_EQ(recording.info.order, fields.ends_with("tb")   ? FieldOrder::top_first
                                  : fields.ends_with("bt") ? FieldOrder::bottom_first
                                                           : of_standard);
  for (const Frame& frame : recording.frames) {
    const Field field = frame.info().field;
    if (fields == "top" || fields == "bottom") {
      EXPECT_EQ(field, fields == "top" ? Field::top : Field::bottom);
    } else {
      EXPECT_EQ(field == Field::frame, fields != "alternate");
    }
    const ImageView& image = frame.image();
    ASSERT_EQ(image.height, field == Field::frame ? recording.info.height : recording.info.height / 2);
    // The first line of a PAL frame holds the wide-screen signal.
    for (int y = pal && field != Field::bottom ? 1 : 0; y < image.height; ++y) {
      const int line = y * line_step(field) + first_line(field);
      for (int x = 0; x < image.width; ++x) {
        const bool white = kind == "lines" ? line % 2 == 1 : (line / 16 + x / 16) % 2 == 0;
        ASSERT_EQ(image.at(x, y) > 128, white) << "line " << line << " of the frame, " << x;
      }
    }
  }
}

struct Format {
  const char* name;
  int bits;
  bool studio;  // 16 to 235, where GREY goes from 0 to 255
};
void PrintTo(const Format& format, std::ostream* stream) { *stream << format.name; }
class VividFormat : public VividTestWith<Format> {};

INSTANTIATE_TEST_SUITE_P(, VividFormat,
                         testing::Values(Format{"Y10", 10, false}, Format{"Y12", 12, false}, Format{"Y16", 16, false},
                                         Format{"Y16-BE", 16, false}, Format{"YUYV", 8, true}, Format{"UYVY", 8, true},
                                         Format{"NV12", 8, true}),
                         [](const auto& tested) {
                           std::string name = tested.param.name;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST_P(VividFormat, GivesTheLumaOfGrey) {
  const Format& format = GetParam();
  ASSERT_EQ(guest_code("format_GREY"), 0) << guest_text("format_GREY.err");
  const std::string step = std::string("format_") + format.name;
  ASSERT_EQ(guest_code(step), 0) << guest_text(step + ".err");
  const GuestRecording grey = guest_recording("format_GREY");
  const GuestRecording recording = guest_recording(step);
  ASSERT_EQ(recording.frames.size(), 2U);
  EXPECT_EQ(recording.info.bits, format.bits);
  const ImageView& expected = grey.frames.at(0).image();
  const ImageView& found = recording.frames[0].image();
  ASSERT_EQ(found.width, expected.width);
  ASSERT_EQ(found.height, expected.height);
  for (int y = 0; y < found.height; ++y) {
    for (int x = 0; x < found.width; ++x) {
      if (format.studio) {
        ASSERT_NEAR(found.at(x, y), 16 + expected.at(x, y) * 219 / 255.0, 1.0) << x << "," << y;
      } else {
        ASSERT_EQ(found.at(x, y) >> (format.bits - 8), expected.at(x, y)) << x << "," << y;
      }
    }
  }
}

/// A device of several planes gives the same pictures, whether its planes lie in one memory or apart.
class VividPlanes : public VividTestWith<Format> {};

INSTANTIATE_TEST_SUITE_P(, VividPlanes,
                         testing::Values(Format{"GREY", 8, false}, Format{"YUYV", 8, true}, Format{"NV12", 8, true},
                                         Format{"NM12", 8, true}, Format{"NM16", 8, true}, Format{"YM12", 8, true}),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST_P(VividPlanes, GiveTheLumaOfOnePlane) {
  const Format& format = GetParam();
  const std::string step = std::string("planes_") + format.name;
  ASSERT_EQ(guest_code(step), 0) << guest_text(step + ".err");
  EXPECT_THAT(guest_text(step + ".err"), testing::HasSubstr(std::string(" ") + format.name + ", none"));
  const GuestRecording grey = guest_recording(format.studio ? "format_YUYV" : "format_GREY");
  const GuestRecording recording = guest_recording(step);
  ASSERT_EQ(recording.frames.size(), 2U);
  for (const Frame& frame : recording.frames) {
    ASSERT_EQ(frame.info().status, FrameStatus::good);
    EXPECT_EQ(frame.info().clock, Clock::monotonic);
    EXPECT_EQ(frame.info().stamped_at, StampedAt::end);
    EXPECT_TRUE(same_pixels(frame.image(), grey.frames.at(0).image()));
  }
}

TEST_F(VividTest, ADeviceOfSeveralPlanesConvertsAndChoosesByItself) {
  ASSERT_EQ(guest_code("planes_RGB3"), 0) << guest_text("planes_RGB3.err");
  const GuestRecording converted = guest_recording("planes_RGB3");
  const GuestRecording expected = guest_recording("format_RGB3");
  ASSERT_EQ(converted.frames.size(), 2U);
  EXPECT_TRUE(same_pixels(converted.frames[1].image(), expected.frames.at(0).image()));
  ASSERT_EQ(guest_code("planes_default"), 0) << guest_text("planes_default.err");
  EXPECT_THAT(guest_text("planes_default.err"), testing::HasSubstr("640x360 GREY, none"));
}

/// Colour formats reach us through libv4l2: the ramp goes from black to white, though not by the same numbers.
TEST_F(VividTest, ConvertsColoursToLuma) {
  for (const std::string format : {"RGB3", "BA81"}) {
    ASSERT_EQ(guest_code("format_" + format), 0) << guest_text("format_" + format + ".err");
    const GuestRecording recording = guest_recording("format_" + format);
    ASSERT_EQ(recording.frames.size(), 2U);
    const ImageView& image = recording.frames[0].image();
    EXPECT_EQ(recording.info.bits, 8);
    const int y = image.height / 2;
    EXPECT_LE(image.at(2, y), 12) << format;
    EXPECT_GE(image.at(image.width - 3, y), 243) << format;
    for (int x = 2; x + 2 < image.width; ++x)
      ASSERT_NEAR(image.at(x, y), 255.0 * x / image.width, 6.0) << format << " at " << x;
  }
}

}  // namespace
}  // namespace vsfind::test
