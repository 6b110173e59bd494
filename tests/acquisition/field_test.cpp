#include <fmt/format.h>
#include <gtest/gtest.h>

#include <vector>

#include "acquisition/errors.h"
#include "acquisition/weave.h"
#include "tests/acquisition/support.h"

namespace vsfind {
namespace {

using test::Picture;
using test::same_pixels;

struct Shape {
  int width;
  int height;
  int bits;
  int padding;
};

class Fields : public testing::TestWithParam<Shape> {};

INSTANTIATE_TEST_SUITE_P(, Fields,
                         testing::Values(Shape{640, 480, 8, 0}, Shape{17, 9, 8, 5}, Shape{31, 8, 12, 6},
                                         Shape{5, 7, 16, 2}, Shape{1, 2, 8, 0}, Shape{3, 1, 10, 0}),
                         [](const auto& tested) {
                           return fmt::format("{}x{}_{}bits_{}padding", tested.param.width, tested.param.height,
                                              tested.param.bits, tested.param.padding);
                         });

TEST_P(Fields, ViewTheFramesOwnLines) {
  const auto [width, height, bits, padding] = GetParam();
  const Picture frame(width, height, bits, 7, padding);
  for (const Field field : {Field::top, Field::bottom}) {
    const ImageView view = field_view(frame.view(), field);
    EXPECT_EQ(view.width, width);
    EXPECT_EQ(view.height, field == Field::top ? (height + 1) / 2 : height / 2);
    for (int y = 0; y < view.height; ++y) {
      const int line = 2 * y + (field == Field::bottom ? 1 : 0);
      EXPECT_EQ(view.data + y * view.stride, frame.view().data + line * frame.view().stride) << "row " << y;
    }
  }
  EXPECT_EQ(field_view(frame.view(), Field::frame).data, frame.view().data);
}

TEST_P(Fields, WovenAgainGiveTheFrame) {
  const auto [width, height, bits, padding] = GetParam();
  const Picture frame(width, height, bits, 11, padding);
  const std::ptrdiff_t stride = width * frame.view().bytes_per_pixel() + 4;
  std::vector<std::uint16_t> memory(static_cast<std::size_t>(stride * height / 2 + 1), 0xabab);
  const ImageView woven = weave(field_view(frame.view(), Field::top), field_view(frame.view(), Field::bottom),
                                reinterpret_cast<std::byte*>(memory.data()), stride);
  EXPECT_TRUE(same_pixels(woven, frame.view()));
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(memory.data());
  for (int y = 0; y < height; ++y) {
    for (std::ptrdiff_t x = stride - 4; x < stride; ++x)
      EXPECT_EQ(bytes[y * stride + x], 0xab) << "written behind row " << y;
  }
}

TEST(Weave, LeavesTheOtherFieldsLinesAlone) {
  const Picture frame(6, 5, 8, 3);
  std::vector<std::uint8_t> memory(30, 0xee);
  weave_field(field_view(frame.view(), Field::bottom), Field::bottom, reinterpret_cast<std::byte*>(memory.data()), 6);
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 6; ++x)
      EXPECT_EQ(memory[static_cast<std::size_t>(y * 6 + x)], y % 2 == 1 ? frame.view().at(x, y) : 0xee);
  }
}

TEST(Weave, RefusesFieldsThatDoNotAgree) {
  std::vector<std::byte> memory(1000);
  const auto refused = [&](const Picture& top, const Picture& bottom) {
    return !test::complaint<UsageError>([&] { weave(top.view(), bottom.view(), memory.data(), 20); }).empty();
  };
  EXPECT_FALSE(refused({8, 4, 8, 1}, {8, 4, 8, 2}));
  EXPECT_FALSE(refused({8, 5, 8, 1}, {8, 4, 8, 2}));
  EXPECT_TRUE(refused({8, 4, 8, 1}, {8, 5, 8, 2}));
  EXPECT_TRUE(refused({8, 6, 8, 1}, {8, 4, 8, 2}));
  EXPECT_TRUE(refused({9, 4, 8, 1}, {8, 4, 8, 2}));
  EXPECT_TRUE(refused({8, 4, 8, 1}, {8, 4, 10, 2}));
}

}  // namespace
}  // namespace vsfind
