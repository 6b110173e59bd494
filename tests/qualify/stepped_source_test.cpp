/// Which frames of a camera are taken for a stage's steps.
#include "app/qualify/stepped_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "app/result_output.h"

namespace vsfind {
namespace {

/// A frame every millisecond, numbered from 100, its timestamp when it came; every fifth one is damaged.
class Camera final : public FrameSource {
 public:
  explicit Camera(std::uint64_t frames) : end_(100 + frames) {}
  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  std::optional<Frame> next() override {
    if (next_ == end_) return std::nullopt;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    FrameInfo info;
    info.sequence = next_++;
    info.timestamp_ns = static_cast<std::int64_t>(info.sequence);
    info.arrival_ns = monotonic_ns();
    if (info.sequence % 5 == 0) info.status = FrameStatus::incomplete;
    return Frame(nullptr, 0, {}, info);
  }
  void stop() noexcept override { end_ = next_; }

 private:
  SourceInfo info_;
  std::uint64_t next_ = 100;
  std::uint64_t end_;
};

/// Two ends of a pipe; what is written into it is somebody's Enter.
class Keys {
 public:
  Keys() { EXPECT_EQ(::pipe(ends_.data()), 0); }
  ~Keys() {
    ::close(ends_[0]);
    end();
  }
  Keys(const Keys&) = delete;
  Keys& operator=(const Keys&) = delete;
  void press(const std::string& text) const {
    EXPECT_EQ(::write(ends_[1], text.data(), text.size()), static_cast<ssize_t>(text.size()));
  }
  void end() {
    if (ends_[1] >= 0) ::close(ends_[1]);
    ends_[1] = -1;
  }
  [[nodiscard]] int input() const { return ends_[0]; }

 private:
  std::array<int, 2> ends_{-1, -1};
};

TEST(SteppedSource, EveryFrameIsTheCameraItself) {
  const auto source = open_stepped(std::make_unique<Camera>(3), {});
  std::vector<std::uint64_t> numbers;
  while (const auto frame = source->next()) numbers.push_back(frame->info().sequence);
  EXPECT_EQ(numbers, (std::vector<std::uint64_t>{100, 101, 102}));
}

TEST(SteppedSource, OneGoodFrameForEachLineExposedAfterIt) {
  Keys keys;
  std::vector<std::size_t> asked;
  StepChoice choice;
  choice.kind = StepChoice::Kind::line;
  choice.input = keys.input();
  choice.on_wait = [&](std::size_t step) { asked.push_back(step); };
  const auto source = open_stepped(std::make_unique<Camera>(1000), choice);
  std::thread presser([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    keys.press("\n");
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    keys.press("yes\n\n");  // a line of anything, and one more
    keys.end();
  });
  std::vector<std::int64_t> taken;
  for (std::uint64_t step = 0; const auto frame = source->next(); ++step) {
    EXPECT_EQ(frame->info().sequence, step);
    EXPECT_EQ(frame->info().status, FrameStatus::good);
    taken.push_back(frame->info().timestamp_ns);
  }
  presser.join();
  ASSERT_EQ(taken.size(), 3U);
  EXPECT_GE(taken[0], 110);  // not before the first Enter
  EXPECT_GE(taken[1] - taken[0], 8);
  EXPECT_GE(taken[2] - taken[1], 2);  // one is left out, as it may have been exposed before
  EXPECT_EQ(asked, (std::vector<std::size_t>{0, 1, 3}));
}

TEST(SteppedSource, OneEverySoManySeconds) {
  StepChoice choice;
  choice.kind = StepChoice::Kind::interval;
  choice.interval_s = 0.05;
  const auto source = open_stepped(std::make_unique<Camera>(5000), choice);
  const auto begin = std::chrono::steady_clock::now();
  for (std::uint64_t step = 0; step < 4; ++step) {
    const auto frame = source->next();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->info().sequence, step);
    EXPECT_EQ(frame->info().status, FrameStatus::good);
  }
  EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(150));
  source->stop();
  EXPECT_FALSE(source->next());
}

}  // namespace
}  // namespace vsfind
