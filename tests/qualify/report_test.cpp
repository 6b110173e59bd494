/// What reports are made of: statistics, charts, pages.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <opencv2/core.hpp>

#include "app/report/chart.h"
#include "app/report/page.h"
#include "app/report/spread.h"

namespace vsfind {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

TEST(Spread, OfValuesWithGaps) {
  const Spread spread = spread_of({1.0, nan, 2.0, -6.0});
  EXPECT_EQ(spread.count, 3U);
  EXPECT_DOUBLE_EQ(spread.mean, -1.0);
  EXPECT_DOUBLE_EQ(spread.sd, std::sqrt((4.0 + 9.0 + 25.0) / 2.0));
  EXPECT_DOUBLE_EQ(spread.rms, std::sqrt(41.0 / 3.0));
  EXPECT_DOUBLE_EQ(spread.max, 6.0);
  EXPECT_EQ(spread_of({}).sd, 0.0);
  EXPECT_EQ(spread_of({3.0}).sd, 0.0);
}

TEST(Spread, Quantiles) {
  EXPECT_EQ(quantile_of({4.0, 1.0, nan, 3.0, 2.0}, 0.5), 2.0);
  EXPECT_EQ(quantile_of({4.0, 1.0, 3.0, 2.0}, 1.0), 4.0);
  EXPECT_EQ(quantile_of({4.0, 1.0, 3.0, 2.0}, 0.0), 1.0);
  EXPECT_EQ(quantile_of({}, 0.5), 0.0);
}

TEST(Chart, TicksAreRound) {
  EXPECT_DOUBLE_EQ(tick_step(10.0, 5), 2.0);
  EXPECT_DOUBLE_EQ(tick_step(0.0031, 8), 0.0005);
  EXPECT_DOUBLE_EQ(tick_step(0.0, 5), 1.0);
  EXPECT_DOUBLE_EQ(tick_step(nan, 5), 1.0);
}

TEST(Chart, AnythingCanBeDrawn) {
  for (const std::vector<double>& y : std::vector<std::vector<double>>{
           {}, {1.0}, {2.0, 2.0}, {nan, nan}, {1.0, nan, 3.0}, {1e-12, -1e-12}, {1e12, 1.0}, {-5e-324, 0.0}}) {
    std::vector<double> x;
    for (std::size_t i = 0; i < y.size(); ++i) x.push_back(static_cast<double>(i));
    Chart chart;
    chart.title = "title";
    chart.curves.push_back({"curve", x, y, chart_colour(0), true, true});
    for (const bool symmetric : {false, true}) {
      chart.symmetric = symmetric;
      const cv::Mat picture = draw_chart(chart);
      EXPECT_EQ(picture.size(), cv::Size(chart_width, chart_height));
    }
  }
}

TEST(Chart, CurveIsWhereItsValuesAre) {
  Chart chart;
  chart.curves.push_back({"", {0.0, 10.0}, {0.0, 0.0}, cv::Scalar(0, 0, 255), true, false});
  chart.symmetric = true;
  const cv::Mat picture = draw_chart(chart);
  cv::Mat red;
  cv::inRange(picture, cv::Scalar(0, 0, 200), cv::Scalar(80, 80, 255), red);
  EXPECT_GT(cv::countNonZero(red), chart_width / 2);
}

TEST(Chart, Histogram) {
  const Chart chart = histogram_of({0.0, 0.1, 0.9, 1.0, nan, 50.0}, 4, 0.8);
  ASSERT_EQ(chart.curves.size(), 1U);
  EXPECT_EQ(chart.curves[0].y, (std::vector<double>{2.0, 0.0, 0.0, 3.0}));
  EXPECT_EQ(histogram_of({}, 4).curves[0].y.size(), 0U);
  EXPECT_EQ(histogram_of({2.0, 2.0}, 4).curves[0].y, std::vector<double>{2.0});
}

TEST(Page, TextIsEscaped) {
  EXPECT_EQ(html_text("<a href=\"x\">'&'\n"), "&lt;a href=&quot;x&quot;&gt;&#39;&amp;&#39; ");
  EXPECT_EQ(html_text("\xff"), "\xef\xbf\xbd");
  Page page("<b>");
  page.paragraph("<script>");
  page.table({"<", ">"}, {{"<i>", "1"}});
  page.key_figures({{"<u>", "x"}});
  EXPECT_THAT(page.html(),
              Not(testing::AnyOf(HasSubstr("<script"), HasSubstr("<b><"), HasSubstr("<i>"), HasSubstr("<u>"))));
}

TEST(Page, GalleryPicturesAreBounded) {
  EXPECT_EQ(for_gallery(cv::Mat(480, 640, CV_8UC3)).size(), cv::Size(640, 480));
  EXPECT_EQ(for_gallery(cv::Mat(4000, 5120, CV_8UC3, cv::Scalar::all(7))).size(), cv::Size(1280, 1000));
  EXPECT_EQ(for_gallery(cv::Mat(1, 9000, CV_8UC3, cv::Scalar::all(7))).size(), cv::Size(1280, 1));
}

TEST(Page, Base64) {
  const auto of = [](const std::string& text) { return base64({text.begin(), text.end()}); };
  EXPECT_EQ(of(""), "");
  EXPECT_EQ(of("f"), "Zg==");
  EXPECT_EQ(of("fo"), "Zm8=");
  EXPECT_EQ(of("foobar"), "Zm9vYmFy");
}

}  // namespace
}  // namespace vsfind
