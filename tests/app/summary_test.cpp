#include "app/summary.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "app/progress.h"

namespace vsfind {
namespace {

using testing::HasSubstr;

TEST(TimeHistogram, QuantilesAgreeWithSortedTimes) {
  TimeHistogram histogram;
  std::vector<double> times;
  std::mt19937 random(5);
  std::lognormal_distribution<double> some(0.0, 2.0);
  for (int i = 0; i < 10001; ++i) {
    times.push_back(some(random));
    histogram.add(times.back());
  }
  std::sort(times.begin(), times.end());
  EXPECT_NEAR(histogram.quantile(0.5) / times[5000], 1.0, 0.011);
  EXPECT_NEAR(histogram.quantile(0.99) / times[9900], 1.0, 0.011);
  EXPECT_EQ(histogram.max(), times.back());
  EXPECT_EQ(histogram.count(), 10001U);
}

TEST(TimeHistogram, TakesAnyTime) {
  TimeHistogram histogram;
  EXPECT_EQ(histogram.quantile(0.5), 0.0);
  for (const double ms : {0.0, -1.0, 1e-9, 1e12, std::nan("")}) histogram.add(ms);
  EXPECT_EQ(histogram.count(), 5U);
  EXPECT_EQ(histogram.max(), 1e12);
}

TEST(Summary, CountsFramesInstancesMissesAndBadFrames) {
  Summary summary;
  FrameResult good;
  PictureResult picture;
  picture.search_ms = 2.0;
  picture.patterns.resize(2);
  picture.patterns[0].matches.resize(3);
  good.pictures = {picture, picture};
  FrameResult bad;
  bad.info.status = FrameStatus::incomplete;
  summary.add(good);
  summary.add(bad);
  EXPECT_EQ(summary.frames, 2U);
  EXPECT_EQ(summary.found, 6U);
  EXPECT_EQ(summary.not_found, 2U);
  EXPECT_EQ(summary.bad, 1U);
  EXPECT_THAT(summary.text(), HasSubstr("2 frames: 6 found, 2 not found, 1 bad; search time median 1.99"));
  EXPECT_THAT(summary.text(), HasSubstr("maximum 2.000 ms"));
  EXPECT_THAT(summary.text(), testing::Not(HasSubstr("dropped")));
  summary.dropped = 4;
  EXPECT_THAT(summary.text(), HasSubstr("4 dropped"));
}

TEST(Progress, ShowsPartRateAndTimeLeft) {
  const std::string text = progress_text(25, 100, 2.5, 80);
  EXPECT_THAT(text, HasSubstr("25% 25/100 frames, 10.0/s, 8 s left"));
  EXPECT_THAT(text, testing::StartsWith("[==="));
  EXPECT_LE(text.size(), 80U);
  EXPECT_EQ(std::count(text.begin(), text.end(), '='), 10);  // a quarter of the bar's 40
}

TEST(Progress, FitsAnyTerminalAndAnyTotal) {
  EXPECT_LE(progress_text(25, 100, 2.5, 10).size(), 10U);
  EXPECT_THAT(progress_text(7, std::nullopt, 1.0, 80), HasSubstr("7 frames, 7.0/s"));
  EXPECT_THAT(progress_text(0, 100, 0.0, 80), testing::Not(HasSubstr("left")));
  EXPECT_THAT(progress_text(200, 100, 1.0, 80), HasSubstr("100%"));
  EXPECT_THAT(progress_text(1, 100000, 1.0, 80), HasSubstr("27:46 h left"));
}

}  // namespace
}  // namespace vsfind
