#include "acquisition/reconnecting_source.h"

#include <gmock/gmock.h>

#include <atomic>
#include <deque>
#include <numeric>
#include <thread>

#include "acquisition/errors.h"
#include "tests/acquisition/support.h"

namespace vsfind {
namespace {

using test::complaint;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

/// When a camera's frames come.
struct Pace {
  std::int64_t begin_ns = 0;
  std::int64_t period_ns = 0;
  std::uint64_t begin = 0;  // its first number
  bool known = false;       // whether it says that it has a rate
};

/// Gives numbered frames and then is lost, or ends.
class Camera final : public FrameSource {
 public:
  Camera(int frames, bool is_lost, const Pace& pace = {}) : pace_(pace), frames_(frames), is_lost_(is_lost) {
    info_.name = "fake";
    info_.width = 8;
    if (pace.known) info_.frame_rate = {100, 1};  // what it says, and not what it does
  }
  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  std::optional<Frame> next() override {
    if (next_ == frames_ && is_lost_) throw CameraError("fake: unplugged");
    if (next_ == frames_) return std::nullopt;
    FrameInfo info;
    info.sequence = pace_.begin + static_cast<std::uint64_t>(next_);
    info.arrival_ns = pace_.begin_ns + next_++ * pace_.period_ns;
    return Frame(nullptr, 0, {}, info);
  }
  void stop() noexcept override {}
  [[nodiscard]] std::string statistics() const override { return "all well"; }

 private:
  SourceInfo info_;
  Pace pace_;
  int frames_;
  bool is_lost_;
  int next_ = 0;
};

class Reconnecting : public testing::Test {
 protected:
  using Factory = std::function<std::unique_ptr<FrameSource>()>;
  std::unique_ptr<FrameSource> source(const ReconnectOptions& options = quick()) {
    auto opened = open_reconnecting(
        "fake",
        [this]() -> std::unique_ptr<FrameSource> {
          attempts_.push_back(std::chrono::steady_clock::now());
          ++attempt_count_;
          if (script_.empty()) throw CameraError("fake: absent");
          const Factory factory = script_.front();
          script_.pop_front();
          return factory();
        },
        options);
    opened->on_event([this](const SourceEvent& event) {
      (event.kind == SourceEvent::Kind::fault       ? faults_
       : event.kind == SourceEvent::Kind::recovered ? recoveries_
                                                    : notes_)
          .push_back(event.text);
    });
    return opened;
  }
  static ReconnectOptions quick() {
    return {std::chrono::milliseconds(1), std::chrono::milliseconds(4), std::chrono::milliseconds(100)};
  }
  static Factory camera(int frames, bool is_lost = true) {
    return [=] { return std::make_unique<Camera>(frames, is_lost); };
  }
  static Factory camera(int frames, const Pace& pace) {
    return [=] { return std::make_unique<Camera>(frames, true, pace); };
  }
  static Factory absent() {
    return []() -> std::unique_ptr<FrameSource> { throw CameraError("fake: absent"); };
  }
  static Factory refused() {
    return []() -> std::unique_ptr<FrameSource> { throw UsageError("fake: no such feature"); };
  }
  static std::vector<std::uint64_t> numbers(FrameSource& source) {
    std::vector<std::uint64_t> all;
    while (const auto frame = source.next()) all.push_back(frame->info().sequence);
    return all;
  }

  std::deque<Factory> script_;
  std::atomic<int> attempt_count_ = 0;  // for another thread to look at
  std::vector<std::chrono::steady_clock::time_point> attempts_;
  std::vector<std::string> faults_;
  std::vector<std::string> recoveries_;
  std::vector<std::string> notes_;
};

TEST_F(Reconnecting, CountsOnWithAGapAndTellsEachFaultOnce) {
  script_ = {camera(3), absent(), absent(), absent(), camera(2), camera(1, false)};
  const auto reconnecting = source();
  EXPECT_EQ(reconnecting->info().name, "fake");
  EXPECT_TRUE(reconnecting->info().live);
  EXPECT_TRUE(attempts_.empty());
  EXPECT_THAT(numbers(*reconnecting), ElementsAre(0, 1, 2, 4, 5, 7));
  EXPECT_THAT(faults_, ElementsAre(HasSubstr("fake: unplugged"), HasSubstr("fake: unplugged")));
  EXPECT_THAT(recoveries_, SizeIs(2));
  EXPECT_THAT(notes_, ElementsAre("fake: absent"));  // the reason changed; the same reason again is not told
  EXPECT_EQ(reconnecting->info().width, 8);
  EXPECT_EQ(reconnecting->statistics(), "all well, reopened 2 times");
}

TEST_F(Reconnecting, LeavesOutAsManyNumbersAsFramesWereMissed) {
  constexpr std::int64_t ms = 1'000'000;
  // 20 ms a frame; the last one at 180 ms, the next at 1680: 1500 ms are 75 periods, 74 frames of which are missed.
  // Then 40 ms a frame, and its count begins at 5; the last one at 2040, the next at 2160: 2 missed.
  script_ = {camera(10, {0, 20 * ms, 0, true}), absent(), camera(10, {1680 * ms, 40 * ms, 5, true}),
             camera(1, {2160 * ms, 40 * ms, 0, true})};
  const auto reconnecting = source();
  std::vector<std::uint64_t> expected(10);
  std::iota(expected.begin(), expected.end(), 0);
  for (std::uint64_t i = 0; i < 10; ++i) expected.push_back(9 + 75 + i);
  expected.push_back(expected.back() + 3);
  std::vector<std::uint64_t> seen;
  for (std::size_t i = 0; i < expected.size(); ++i) seen.push_back(reconnecting->next()->info().sequence);
  EXPECT_EQ(seen, expected);
}

TEST_F(Reconnecting, LeavesOutOneNumberWhereNothingTellsHowManyFramesWereMissed) {
  constexpr std::int64_t s = 1'000'000'000;
  // Triggered, then too few to tell, then a clock that stands still.
  script_ = {camera(10, {0, s, 0, false}), camera(2, {100 * s, s, 0, true}), camera(9, {200 * s, 0, 0, true}),
             camera(1, {300 * s, s, 0, true})};
  const auto reconnecting = source();
  std::vector<std::uint64_t> seen;
  for (int i = 0; i < 22; ++i) seen.push_back(reconnecting->next()->info().sequence);
  EXPECT_EQ(seen[9], 9U);
  EXPECT_EQ(seen[10], 11U);
  EXPECT_EQ(seen[11], 12U);
  EXPECT_EQ(seen[12], 14U);
  EXPECT_EQ(seen[20], 22U);
  EXPECT_EQ(seen[21], 24U);
}

TEST_F(Reconnecting, WaitsForACameraThatIsAbsentAtFirst) {
  script_ = {absent(), absent(), camera(2, false)};
  EXPECT_THAT(numbers(*source()), ElementsAre(0, 1));
  EXPECT_THAT(faults_, SizeIs(1));
  EXPECT_THAT(recoveries_, SizeIs(1));
}

TEST_F(Reconnecting, ThePauseGrowsToItsLongest) {
  const auto reconnecting =
      source({std::chrono::milliseconds(20), std::chrono::milliseconds(80), std::chrono::milliseconds(500)});
  EXPECT_THROW(static_cast<void>(reconnecting->next()), CameraError);
  ASSERT_GE(attempts_.size(), 3U);
  EXPECT_LE(attempts_.size(), 10U);  // 20, 40, 80, 80, 80, … ms
  EXPECT_GE(attempts_[1] - attempts_[0], std::chrono::milliseconds(20));
  EXPECT_GE(attempts_[2] - attempts_[1], std::chrono::milliseconds(40));
}

TEST_F(Reconnecting, GivesUpAfterItsTime) {
  script_ = {camera(1)};
  const auto reconnecting = source();
  EXPECT_TRUE(reconnecting->next());
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_THAT(complaint<CameraError>([&] { static_cast<void>(reconnecting->next()); }),
              HasSubstr("given up after 0.1 s"));
  EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(95));
}

TEST_F(Reconnecting, WrongSettingsEndItAtTheStartOnly) {
  script_ = {refused()};
  EXPECT_THROW(static_cast<void>(source()->next()), UsageError);
  script_ = {camera(1), refused(), camera(1, false)};
  EXPECT_THAT(numbers(*source()), ElementsAre(0, 2));
}

TEST_F(Reconnecting, StopEndsTheWait) {
  const auto reconnecting = source({std::chrono::hours(1), std::chrono::hours(1), std::nullopt});
  std::thread later([&] {
    while (attempt_count_ == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    reconnecting->stop();
  });
  EXPECT_FALSE(reconnecting->next());
  later.join();
  EXPECT_FALSE(reconnecting->next());
}

}  // namespace
}  // namespace vsfind
