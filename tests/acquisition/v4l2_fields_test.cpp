#include "acquisition/v4l2_fields.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <tuple>
#include <vector>

#include "acquisition/errors.h"
#include "acquisition/trouble.h"
#include "tests/acquisition/support.h"

namespace vsfind {
namespace {

using test::Picture;
using testing::HasSubstr;

TEST(BufferFields, AreNamedAsV4l2NamesThem) {
  for (const auto& [fields, word] : buffer_fields_names) {
    EXPECT_EQ(parse_buffer_fields(std::string(word)), fields);
    EXPECT_EQ(name(fields), word);
  }
  EXPECT_EQ(parse_buffer_fields("SEQ-TB"), BufferFields::seq_tb);
  EXPECT_EQ(parse_buffer_fields("Interlaced_BT"), BufferFields::interlaced_bt);
  const std::string complaint = test::complaint<UsageError>([] { static_cast<void>(parse_buffer_fields("topfirst")); });
  EXPECT_THAT(complaint, HasSubstr("'topfirst'"));
  for (const auto& [fields, word] : buffer_fields_names) EXPECT_THAT(complaint, HasSubstr(std::string(word)));
}

TEST(BufferFields, TellWhichFieldIsExposedFirst) {
  using enum BufferFields;
  using enum FieldOrder;
  for (const bool lines_525 : {false, true}) {
    EXPECT_EQ(field_order(none, lines_525), progressive);
    EXPECT_EQ(field_order(interlaced_tb, lines_525), top_first) << "what the buffer says goes before the standard";
    EXPECT_EQ(field_order(seq_tb, lines_525), top_first);
    EXPECT_EQ(field_order(interlaced_bt, lines_525), bottom_first);
    EXPECT_EQ(field_order(seq_bt, lines_525), bottom_first);
    for (const auto fields : {interlaced, alternate, top, bottom})
      EXPECT_EQ(field_order(fields, lines_525), lines_525 ? bottom_first : top_first) << name(fields);
  }
}

TEST(BufferFields, TellWhatAPictureIs) {
  using enum BufferFields;
  for (const auto fields : {none, interlaced, interlaced_tb, interlaced_bt, seq_tb, seq_bt}) {
    EXPECT_EQ(picture_field(fields, fields), Field::frame);
    EXPECT_EQ(frame_rows(fields, 576), 576);
    EXPECT_EQ(buffer_rows(fields, 576), 576);
  }
  EXPECT_EQ(picture_field(top, any), Field::top);
  EXPECT_EQ(picture_field(bottom, any), Field::bottom);
  EXPECT_EQ(picture_field(alternate, top), Field::top);
  EXPECT_EQ(picture_field(alternate, bottom), Field::bottom);
  EXPECT_EQ(picture_field(alternate, any), std::nullopt);
  EXPECT_EQ(picture_field(alternate, interlaced), std::nullopt);
  for (const auto fields : {alternate, top, bottom}) {
    EXPECT_EQ(frame_rows(fields, 288), 576);
    EXPECT_EQ(buffer_rows(fields, 576), 288);
  }
}

/// A driver's buffer of YUYV (luma at every second byte) with a frame in it, as the order says.
struct DriverBuffer {
  DriverBuffer(const ImageView& frame, BufferFields fields) : stride(frame.width * 2 + 6) {
    const auto lines = [&]() -> std::vector<int> {
      std::vector<int> top;
      std::vector<int> bottom;
      std::vector<int> all;
      for (int y = 0; y < frame.height; ++y) {
        (y % 2 == 0 ? top : bottom).push_back(y);
        all.push_back(y);
      }
      std::vector<int> first = fields == BufferFields::seq_bt ? bottom : top;
      const std::vector<int>& second = fields == BufferFields::seq_bt ? top : bottom;
      if (fields == BufferFields::top) return top;
      if (fields == BufferFields::bottom) return bottom;
      if (fields != BufferFields::seq_tb && fields != BufferFields::seq_bt) return all;
      first.insert(first.end(), second.begin(), second.end());
      return first;
    }();
    rows = static_cast<int>(lines.size());
    bytes.assign(static_cast<std::size_t>(stride * rows), std::byte{0x80});
    for (int row = 0; row < rows; ++row) {
      for (int x = 0; x < frame.width; ++x)
        bytes[static_cast<std::size_t>(row * stride + 2 * x)] =
            static_cast<std::byte>(frame.at(x, lines[static_cast<std::size_t>(row)]));
    }
  }
  std::ptrdiff_t stride;
  int rows = 0;
  std::vector<std::byte> bytes;
};

class FieldsInABuffer : public testing::TestWithParam<std::tuple<BufferFields, int>> {};

INSTANTIATE_TEST_SUITE_P(, FieldsInABuffer,
                         testing::Combine(testing::Values(BufferFields::none, BufferFields::interlaced,
                                                          BufferFields::interlaced_tb, BufferFields::interlaced_bt,
                                                          BufferFields::seq_tb, BufferFields::seq_bt, BufferFields::top,
                                                          BufferFields::bottom),
                                          testing::Values(8, 9)),
                         [](const auto& tested) {
                           return fmt::format("{}_{}rows", name(std::get<0>(tested.param)), std::get<1>(tested.param));
                         });

TEST_P(FieldsInABuffer, GetToTheirLines) {
  const auto [fields, frame_height] = GetParam();
  const Picture frame(12, frame_height, 8, 17);
  const DriverBuffer buffer(frame.view(), fields);
  constexpr std::ptrdiff_t stride = 16;
  std::vector<std::byte> memory(static_cast<std::size_t>(stride * buffer.rows), std::byte{0xee});
  unpack(*luma_layout(*fourcc_from_name("YUYV")), fields, buffer.bytes.data(), buffer.stride, 12, buffer.rows,
         memory.data(), stride);
  const Field field = picture_field(fields, fields).value();
  EXPECT_TRUE(test::same_pixels({memory.data(), 12, buffer.rows, stride, 8}, field_view(frame.view(), field)));
  for (int y = 0; y < buffer.rows; ++y) {
    for (std::ptrdiff_t x = 12; x < stride; ++x)
      EXPECT_EQ(memory[static_cast<std::size_t>(y * stride + x)], std::byte{0xee}) << "written behind row " << y;
  }
}

TEST(SequenceCounter, CountsFromTheFirstFrameAndKeepsGaps) {
  SequenceCounter counter;
  EXPECT_EQ(counter.next(1000, Field::frame), 0U);
  EXPECT_EQ(counter.next(1001, Field::frame), 1U);
  EXPECT_EQ(counter.missing(), 0U);
  EXPECT_EQ(counter.next(1005, Field::frame), 5U);
  EXPECT_EQ(counter.missing_before(), 3U);
  EXPECT_EQ(counter.next(1006, Field::frame), 6U);
  EXPECT_EQ(counter.missing_before(), 0U);
  EXPECT_EQ(counter.missing(), 3U);
}

TEST(SequenceCounter, PassesTheEndOf32Bits) {
  SequenceCounter counter;
  std::uint64_t expected = 0;
  for (std::uint32_t sequence = 0xfffffffdU; sequence != 4; ++sequence)
    EXPECT_EQ(counter.next(sequence, Field::frame), expected++);
  EXPECT_EQ(counter.missing(), 0U);
  // Far beyond 2^32, in the largest steps that are still forward.
  std::uint32_t sequence = 3;
  std::uint64_t number = expected - 1;
  for (int i = 0; i < 5; ++i) {
    sequence += 0x7fffffffU;
    number += 0x7fffffffU;
    EXPECT_EQ(counter.next(sequence, Field::frame), number);
  }
  EXPECT_GT(number, std::uint64_t{1} << 33U);
}

TEST(SequenceCounter, CountsForADriverThatDoesNotOrThatStartsAgain) {
  SequenceCounter counter;
  for (std::uint64_t i = 0; i < 4; ++i) EXPECT_EQ(counter.next(0, Field::frame), i);
  EXPECT_EQ(counter.next(7, Field::frame), 10U);
  EXPECT_EQ(counter.next(0, Field::frame), 11U) << "started again";
  EXPECT_EQ(counter.next(1, Field::frame), 12U);
}

TEST(SequenceCounter, FieldsOfAFrameShareItsNumber) {
  SequenceCounter pal(2, Field::top);
  EXPECT_EQ(pal.next(4, Field::top), 0U);
  EXPECT_EQ(pal.next(4, Field::bottom), 0U);
  EXPECT_EQ(pal.next(5, Field::top), 1U);
  EXPECT_EQ(pal.missing(), 0U);
  EXPECT_EQ(pal.next(6, Field::top), 2U);
  EXPECT_EQ(pal.missing_before(), 1U) << "a bottom field is lost";
  EXPECT_EQ(pal.next(7, Field::bottom), 3U);
  EXPECT_EQ(pal.missing_before(), 2U) << "a bottom and a top field are lost";
  EXPECT_EQ(pal.next(9, Field::top), 5U);
  EXPECT_EQ(pal.missing_before(), 2U) << "a whole frame is lost";
  EXPECT_EQ(pal.missing(), 5U);

  SequenceCounter ntsc(2, Field::bottom);
  EXPECT_EQ(ntsc.next(0, Field::top), 0U) << "the stream may begin with the later field";
  EXPECT_EQ(ntsc.next(1, Field::bottom), 1U);
  EXPECT_EQ(ntsc.next(1, Field::top), 1U);
  EXPECT_EQ(ntsc.missing(), 0U);

  SequenceCounter silent(2, Field::top);
  EXPECT_EQ(silent.next(0, Field::top), 0U);
  EXPECT_EQ(silent.next(0, Field::bottom), 0U);
  EXPECT_EQ(silent.next(0, Field::top), 1U);
  EXPECT_EQ(silent.next(0, Field::bottom), 1U);
}

TEST(Trouble, IsToldOfWhenItBeginsAndWhenItIsOver) {
  Trouble trouble;
  using enum Trouble::Change;
  EXPECT_EQ(trouble.update(0), none);
  EXPECT_EQ(trouble.update(3), begun);
  for (int i = 0; i < 50; ++i) EXPECT_EQ(trouble.update(0), none);
  EXPECT_EQ(trouble.update(2), none) << "once, not every time";
  for (int i = 1; i < Trouble::quiet_frames; ++i) EXPECT_EQ(trouble.update(0), none) << i;
  EXPECT_EQ(trouble.update(0), ended);
  EXPECT_EQ(trouble.count(), 5U);
  EXPECT_EQ(trouble.update(0), none);
  EXPECT_EQ(trouble.update(1), begun);
  EXPECT_EQ(trouble.count(), 1U);
}

}  // namespace
}  // namespace vsfind
