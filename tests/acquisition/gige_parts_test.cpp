// The parts of the GigE backend that need no camera: frame ids and pixel formats.

#include <gmock/gmock.h>

#include "acquisition/gige_field_count.h"
#include "acquisition/gige_frame_count.h"
#include "acquisition/gige_pixels.h"
#include "acquisition/network_path.h"

namespace vsfind {
namespace {

using testing::ElementsAre;

TEST(GigeFrameCount, CountsPastTheWrapAndKeepsGaps) {
  GigeFrameCount count;
  EXPECT_EQ(count.of_whole_frame(65533), 0U);
  EXPECT_EQ(count.of_whole_frame(65534), 1U);
  EXPECT_EQ(count.of_whole_frame(65535), 2U);
  EXPECT_EQ(count.of_whole_frame(1), 3U);
  EXPECT_EQ(count.of_whole_frame(5), 7U);
  for (std::uint64_t i = 6; i <= 65535; ++i) count.of_whole_frame(i);
  EXPECT_EQ(count.of_whole_frame(2), 7U + 65530U + 2U);
}

TEST(GigeFrameCount, ExtendedIdsDoNotWrap) {
  GigeFrameCount count;
  EXPECT_EQ(count.of_whole_frame(65530), 0U);
  EXPECT_EQ(count.of_whole_frame(65540), 10U);
  EXPECT_EQ(count.of_whole_frame(100'000), 34'470U);
  EXPECT_EQ(count.of_whole_frame(7), 34'471U);  // counted anew by the camera
}

TEST(GigeFrameCount, AnIdThatGoesBackIsTheNextOne) {
  GigeFrameCount count;
  EXPECT_EQ(count.of_whole_frame(1000), 0U);
  EXPECT_EQ(count.of_whole_frame(1), 1U);
  EXPECT_EQ(count.of_whole_frame(2), 2U);
  EXPECT_EQ(count.of_whole_frame(2), 3U);
}

TEST(GigeFrameCount, ABrokenFrameMayShowAnOldId) {
  GigeFrameCount count;
  bool known = false;
  EXPECT_EQ(count.of_whole_frame(100), 0U);
  EXPECT_EQ(count.of_broken_frame(102, known), 2U);
  EXPECT_TRUE(known);
  EXPECT_EQ(count.of_broken_frame(92, known), 3U);
  EXPECT_FALSE(known);
  EXPECT_EQ(count.of_whole_frame(104), 4U);
}

using Placed = std::pair<std::uint64_t, bool>;
Placed placed(const GigeFieldCount::Place& place) { return {place.frame, place.second}; }

TEST(GigeFieldCount, FieldsComeInTurnWhateverIsLostAndPastTheWrap) {
  GigeFieldCount count;
  EXPECT_EQ(placed(count.of_whole_field(1)), Placed(0, false));
  EXPECT_EQ(placed(count.of_whole_field(2)), Placed(0, true));
  EXPECT_EQ(placed(count.of_whole_field(4)), Placed(1, true));
  EXPECT_EQ(placed(count.of_whole_field(7)), Placed(3, false));
  EXPECT_EQ(placed(count.of_whole_field(65535)), Placed(32767, false));
  EXPECT_EQ(placed(count.of_whole_field(1)), Placed(32767, true)) << "two odd ids in a row are no two same fields";
  EXPECT_EQ(placed(count.of_whole_field(4)), Placed(32769, false));
}

TEST(GigeFieldCount, AnIdLaterThanTheFirstIsNotTakenForTheFirst) {
  GigeFieldCount count;
  EXPECT_EQ(placed(count.of_whole_field(4)), Placed(1, true));
  EXPECT_EQ(placed(count.of_whole_field(5)), Placed(2, false));
}

TEST(GigeFieldCount, ACameraMayBeginItsIdsElsewhere) {
  GigeFieldCount count;
  bool known = true;
  EXPECT_EQ(placed(count.of_broken_field(0, known)), Placed(0, false));
  EXPECT_FALSE(known);
  EXPECT_EQ(placed(count.of_broken_field(65402, known)), Placed(0, true));
  EXPECT_TRUE(known);
  EXPECT_EQ(placed(count.of_whole_field(65403)), Placed(1, false));
  GigeFieldCount extended;
  EXPECT_EQ(placed(extended.of_whole_field(1'000'000)), Placed(0, false));
  EXPECT_EQ(placed(extended.of_whole_field(1'000'001)), Placed(0, true));
}

TEST(GigeFieldCount, ABrokenFieldWithAnOldIdSwapsNothing) {
  GigeFieldCount count;
  bool known = false;
  EXPECT_EQ(placed(count.of_whole_field(1)), Placed(0, false));
  EXPECT_EQ(placed(count.of_broken_field(3, known)), Placed(1, false));
  EXPECT_TRUE(known);
  EXPECT_EQ(placed(count.of_broken_field(1, known)), Placed(1, true));
  EXPECT_FALSE(known);
  EXPECT_EQ(placed(count.of_broken_field(60000, known)), Placed(2, false));
  EXPECT_FALSE(known);
  EXPECT_EQ(placed(count.of_whole_field(4)), Placed(1, true));
}

TEST(GigeFieldCount, ABrokenFieldInABufferNeverUsedShowsTheIdZero) {
  bool known = true;
  GigeFieldCount fields;
  EXPECT_EQ(placed(fields.of_whole_field(65401)), Placed(0, false));  // 0 would lie 134 ahead, past the wrap
  EXPECT_EQ(placed(fields.of_broken_field(0, known)), Placed(0, true));
  EXPECT_FALSE(known);
  EXPECT_EQ(placed(fields.of_whole_field(65403)), Placed(1, false));
}

TEST(GigeFrameCount, ABrokenFrameMayHaveNoId) {
  // A buffer that was never used before has 0, which is no id: just before the wrap, too.
  GigeFrameCount count;
  bool known = true;
  EXPECT_EQ(count.of_whole_frame(65412), 0U);
  EXPECT_EQ(count.of_broken_frame(0, known), 1U);
  EXPECT_FALSE(known);
  EXPECT_EQ(count.of_whole_frame(65414), 2U);
}

TEST(GigeFrameCount, BrokenFramesBeforeTheFirstWholeOneAreCounted) {
  GigeFrameCount count;
  bool known = true;
  EXPECT_EQ(count.of_broken_frame(0, known), 0U);
  EXPECT_FALSE(known);
  EXPECT_EQ(count.of_broken_frame(78, known), 1U);
  EXPECT_TRUE(known);
  EXPECT_EQ(count.of_broken_frame(79, known), 2U);
  EXPECT_EQ(count.of_whole_frame(81), 4U);
}

std::vector<int> luma(std::uint32_t format, const std::vector<std::uint8_t>& bytes, int width, int height) {
  const auto pixels = gige_pixels(format);
  if (!pixels || bytes.size() < pixels->bytes(width, height)) return {};
  std::vector<std::uint16_t> room(static_cast<std::size_t>(width * height));
  const ImageView view = luma_from_gige(*pixels, reinterpret_cast<const std::byte*>(bytes.data()), width, height, 0,
                                        reinterpret_cast<std::byte*>(room.data()));
  std::vector<int> values;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) values.push_back(view.at(x, y));
  }
  return values;
}

TEST(GigePixels, PackedOnesAreUnpacked) {
  // GigE Vision's: the high bits of two pixels around a byte with the low ones.
  EXPECT_THAT(luma(0x010C0006, {0xAB, 0x3C, 0x12, 0xFF, 0x0F}, 3, 1), ElementsAre(0xABC, 0x123, 0xFFF));
  EXPECT_THAT(luma(0x010C0004, {0xFF, 0x21, 0x80}, 2, 1), ElementsAre(0x3FD, 0x202));
  // PFNC's: bit after bit, the lowest first.
  EXPECT_THAT(luma(0x010C0047, {0xBC, 0x3A, 0x12}, 2, 1), ElementsAre(0xABC, 0x123));
  EXPECT_THAT(luma(0x010A0046, {0x01, 0x08, 0x30, 0x00, 0x01}, 4, 1), ElementsAre(1, 2, 3, 4));
}

TEST(GigePixels, OddNumbersOfPixelsTakeTheirPartOfTheLastBytes) {
  EXPECT_EQ(gige_pixels(0x010C0006)->bytes(3, 1), 5U);
  EXPECT_EQ(gige_pixels(0x010A0046)->bytes(3, 3), 12U);
  EXPECT_EQ(gige_pixels(0x02180014)->bytes(3, 3), 27U);
  EXPECT_EQ(gige_pixels(0x01100007)->bytes(3, 3), 18U);
}

TEST(GigePixels, ColourBecomesLuma) {
  EXPECT_THAT(luma(0x02180014, {255, 0, 0, 0, 255, 0, 0, 0, 255}, 3, 1), ElementsAre(76, 150, 29));  // RGB
  EXPECT_THAT(luma(0x02180015, {255, 0, 0, 0, 255, 0, 0, 0, 255}, 3, 1), ElementsAre(29, 150, 76));  // BGR
  EXPECT_THAT(luma(0x0210001F, {1, 10, 2, 20}, 2, 1), ElementsAre(10, 20));                          // UYVY
  EXPECT_THAT(luma(0x02100032, {10, 1, 20, 2}, 2, 1), ElementsAre(10, 20));                          // YUYV
  EXPECT_THAT(luma(0x020C001E, {1, 10, 20, 2, 30, 40}, 4, 1), ElementsAre(10, 20, 30, 40));
}

TEST(GigePixels, BayerColoursAreWhereTheirNamesSay) {
  // A picture of pure red: only the red places are bright, and the luma is that of red everywhere.
  const auto red_at = [](int red_x, int red_y) {
    std::vector<std::uint8_t> bytes(64);
    for (int y = 0; y < 8; ++y) {
      for (int x = 0; x < 8; ++x)
        bytes[static_cast<std::size_t>(8 * y + x)] = x % 2 == red_x && y % 2 == red_y ? 200 : 0;
    }
    return bytes;
  };
  for (const auto& [format, x, y] : {std::tuple{0x01080009U, 0, 0}, std::tuple{0x01080008U, 1, 0},
                                     std::tuple{0x0108000AU, 0, 1}, std::tuple{0x0108000BU, 1, 1}}) {
    SCOPED_TRACE(gige_pixel_format_name(format));
    const auto values = luma(format, red_at(x, y), 8, 8);
    ASSERT_EQ(values.size(), 64U);
    for (const int value : values) EXPECT_NEAR(value, 60, 1);
  }
}

TEST(GigePixels, UnknownFormatsAreNothing) {
  EXPECT_FALSE(gige_pixels(0x8108FFFF));
  EXPECT_EQ(gige_pixel_format_name(0x8108FFFF), "");
  EXPECT_EQ(gige_pixel_format_name(0x01080001), "Mono8");
}

TEST(NetworkPath, TheWayToThisMachineIsItsLoopback) {
  const auto path = path_to("127.0.0.1");
  ASSERT_TRUE(path);
  EXPECT_EQ(path->address, "127.0.0.1");
  EXPECT_EQ(path->interface, "lo");
  EXPECT_TRUE(path->loopback);
  EXPECT_GE(path->mtu, 1500);
  EXPECT_FALSE(path_to("no address"));
  EXPECT_TRUE(is_ipv4_address("10.0.0.1"));
  EXPECT_FALSE(is_ipv4_address("camera"));
}

}  // namespace
}  // namespace vsfind
