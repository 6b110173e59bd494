#include "calibration/pixel_aspect.h"

#include <gtest/gtest.h>

#include "acquisition/errors.h"

namespace vsfind {
namespace {

TEST(PixelAspect, ReadsNamesAndRatios) {
  EXPECT_DOUBLE_EQ(pixel_aspect_from_text("pal"), 59.0 / 54.0);
  EXPECT_DOUBLE_EQ(pixel_aspect_from_text("ntsc"), 10.0 / 11.0);
  EXPECT_DOUBLE_EQ(pixel_aspect_from_text("4320:4739"), 4320.0 / 4739.0);
  EXPECT_DOUBLE_EQ(pixel_aspect_from_text("1.0925:1"), 1.0925);
}

TEST(PixelAspect, RefusesTheRest) {
  for (const char* text : {"", "PAL", ":", "1:", ":1", "1", "1:0", "0:1", "-1:-1", "nan:1", "inf:inf", "1:1:1", "1:1x",
                           " 1:1", "11:1", "1:11", "1e400:1"}) {
    EXPECT_THROW((void)pixel_aspect_from_text(text), UsageError) << text;
  }
}

}  // namespace
}  // namespace vsfind
