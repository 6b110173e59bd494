#include "app/values.h"

#include <gmock/gmock.h>

#include <limits>

namespace vsfind {
namespace {

using testing::HasSubstr;

/// What a parser complains about, or "".
template <typename Parse>
std::string complaint(Parse parse) {
  try {
    (void)parse();
    return {};
  } catch (const ValueError& error) {
    return error.what();
  }
}

TEST(Values, RangeOfTwoNumbersOrOne) {
  const Range both = parse_range("-45:45.5", -360, 360, "degrees");
  EXPECT_EQ(both.min, -45.0);
  EXPECT_EQ(both.max, 45.5);
  const Range one = parse_range("-.5", -360, 360, "degrees");
  EXPECT_EQ(one.min, -0.5);
  EXPECT_EQ(one.max, -0.5);
}

TEST(Values, RangeComplaintsNameTextFaultAndAllowedForm) {
  for (const char* text : {"", ":", "1:", ":1", "1:2:3", "a:b", "1,5:2", "nan:1", "1:inf", " 1:2", "0x1:2", "1:2 "}) {
    const std::string line = complaint([&] { return parse_range(text, -360, 360, "degrees"); });
    EXPECT_THAT(line, HasSubstr("is not a range")) << text;
    EXPECT_THAT(line, HasSubstr("MIN:MAX")) << text;
  }
  EXPECT_THAT(complaint([] { return parse_range("45:-45", -360, 360, "degrees"); }),
              testing::AllOf(HasSubstr("'45:-45'"), HasSubstr("minimum lies above"), HasSubstr("degrees")));
  EXPECT_THAT(complaint([] { return parse_range("-361:0", -360, 360, "degrees"); }),
              testing::AllOf(HasSubstr("out of range"), HasSubstr("-360 to 360")));
}

TEST(Values, RoiOfWholePixels) {
  const Roi roi = parse_roi("1,2,30,40");
  EXPECT_EQ(roi.x, 1);
  EXPECT_EQ(roi.y, 2);
  EXPECT_EQ(roi.width, 30);
  EXPECT_EQ(roi.height, 40);
  for (const char* text : {"", "1,2,3", "1,2,3,4,5", "1,2,3,x", "1.5,2,3,4", "1,,3,4", "99999999999,0,1,1"}) {
    EXPECT_THAT(complaint([&] { return parse_roi(text); }), HasSubstr("X,Y,W,H")) << text;
  }
  for (const char* text : {"-1,2,3,4", "1,-2,3,4", "1,2,0,4", "1,2,3,-4", "2147483647,0,1,1", "0,0,2147483647,1"}) {
    EXPECT_THAT(complaint([&] { return parse_roi(text); }), HasSubstr("out of range")) << text;
  }
}

TEST(Values, PointOfTwoNumbers) {
  EXPECT_EQ(parse_point("1.5,-2"), Eigen::Vector2d(1.5, -2.0));
  for (const char* text : {"", "1", "1,2,3", "x,1", "1e99,0"}) {
    EXPECT_THAT(complaint([&] { return parse_point(text); }), HasSubstr("X,Y")) << text;
  }
}

TEST(Values, NumbersStayInTheirBounds) {
  EXPECT_EQ(parse_number("0.25", 0, 1), 0.25);
  EXPECT_THAT(complaint([] { return parse_number("1.01", 0, 1); }), HasSubstr("from 0 to 1"));
  EXPECT_THAT(complaint([] { return parse_number("nan", 0, 1); }), HasSubstr("is not a number"));
  EXPECT_EQ(parse_whole("64", 1, 64), 64);
  EXPECT_THAT(complaint([] { return parse_whole("65", 1, 64); }), HasSubstr("from 1 to 64"));
  EXPECT_THAT(complaint([] { return parse_whole("1.5", 1, 64); }), HasSubstr("is not a whole number"));
  EXPECT_THAT(complaint([] { return parse_whole("99999999999999999999", 0, std::numeric_limits<int>::max()); }),
              HasSubstr("at least 0"));
}

TEST(Values, PixelAspectByRatioOrName) {
  EXPECT_DOUBLE_EQ(parse_pixel_aspect("pal").value, 59.0 / 54.0);
  EXPECT_DOUBLE_EQ(parse_pixel_aspect("ntsc").value, 10.0 / 11.0);
  EXPECT_DOUBLE_EQ(parse_pixel_aspect("4320:4739").value, 4320.0 / 4739.0);
  for (const char* text : {"", "1", "0:1", "1:0", "secam", "1:100", "-1:1"}) {
    EXPECT_THAT(complaint([&] { return parse_pixel_aspect(text); }), HasSubstr("allowed")) << text;
  }
}

TEST(Values, WordsNameTheNearestAndAll) {
  const std::vector<std::pair<std::string, int>> words{{"frame", 1}, {"split", 2}};
  EXPECT_EQ(parse_word<int>("split", words), 2);
  const std::string line = complaint([&] { return parse_word<int>("splitt", words); });
  EXPECT_THAT(line, HasSubstr("did you mean split?"));
  EXPECT_THAT(line, HasSubstr("(allowed: frame, split)"));
}

TEST(Values, LongGarbageIsCutInTheComplaint) {
  EXPECT_LT(complaint([] { return parse_number(std::string(100000, 'x'), 0, 1); }).size(), 300U);
}

}  // namespace
}  // namespace vsfind
