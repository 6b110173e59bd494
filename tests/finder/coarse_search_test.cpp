/// The exhaustive search finds what is there, and gives up when its time is over.
#include "finder/coarse_search.h"

#include <gtest/gtest.h>

#include <chrono>
#include <random>
#include <vector>

namespace vsfind {
namespace {

using Clock = std::chrono::steady_clock;

/// Noise in which a block of 16 by 16 pixels around (70, 40) is what is looked for.
class CoarseSearchTest : public testing::Test {
 protected:
  static constexpr int width = 160;
  static constexpr int height = 120;

  CoarseSearchTest() : pixels_(static_cast<std::size_t>(width) * height) {
    std::mt19937_64 random(3);
    for (std::uint8_t& pixel : pixels_) pixel = static_cast<std::uint8_t>(random() >> 56U);
    level_.data = pixels_.data();
    level_.width = width;
    level_.height = height;
    level_.stride = width;
    for (int y = -8; y < 8; y += 2) {
      for (int x = -8; x < 8; x += 2) {
        PatternPoint point;
        point.x = x;
        point.y = y;
        point.value = static_cast<float>(pixels_[static_cast<std::size_t>((40 + y) * width + 70 + x)]);
        looked_for_.push_back(point);
      }
    }
    points_ = CoarsePoints(looked_for_);
    task_.points = &points_;
    task_.hypotheses = &hypotheses_;
    task_.projection = {&mapping_, &level_, 1.0};
  }

  std::vector<std::uint8_t> pixels_;
  Level level_;
  Mapping mapping_;
  std::vector<PatternPoint> looked_for_;
  CoarsePoints points_;
  std::vector<Hypothesis> hypotheses_{{}, {90.0, 1.0, 1.0}, {180.0, 1.0, 1.0}};
  CoarseTask task_;
  CoarseSearch search_;
  std::vector<CoarseCandidate> found_;
};

TEST_F(CoarseSearchTest, FindsItWhereThereIsTime) {
  for (const Clock::time_point deadline : {Clock::time_point::max(), Clock::now() + std::chrono::hours(1)}) {
    task_.deadline = deadline;
    for (const int workers : {1, 3}) {
      ThreadPool threads(workers);
      ASSERT_TRUE(search_.run(task_, threads, found_));
      ASSERT_FALSE(found_.empty());
      EXPECT_EQ(found_[0].pose.x, 70.0);
      EXPECT_EQ(found_[0].pose.y, 40.0);
      EXPECT_EQ(found_[0].pose.angle_deg, 0.0);
    }
  }
}

TEST_F(CoarseSearchTest, GivesUpWhereItsTimeIsOverAndLeavesNothingOfAnEarlierPicture) {
  ThreadPool threads(2);
  ASSERT_TRUE(search_.run(task_, threads, found_));
  task_.deadline = Clock::now() - std::chrono::seconds(1);
  EXPECT_FALSE(search_.run(task_, threads, found_));
  EXPECT_TRUE(found_.empty());
}

}  // namespace
}  // namespace vsfind
