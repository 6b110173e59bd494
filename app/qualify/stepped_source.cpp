#include "app/qualify/stepped_source.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <utility>

#include "app/result_output.h"

namespace vsfind {
namespace {

class SteppedSource final : public FrameSource {
 public:
  SteppedSource(std::unique_ptr<FrameSource> camera, StepChoice choice)
      : camera_(std::move(camera)), choice_(std::move(choice)) {}

  [[nodiscard]] const SourceInfo& info() const override { return camera_->info(); }
  void stop() noexcept override { camera_->stop(); }
  [[nodiscard]] std::string statistics() const override { return camera_->statistics(); }
  void on_event(EventHandler handler) override { camera_->on_event(std::move(handler)); }

  std::optional<Frame> next() override {
    if (choice_.kind == StepChoice::Kind::line && lines_ == 0 && choice_.on_wait) choice_.on_wait(step_);
    bool begun = false;
    std::int64_t begin_ns = 0;
    int since = 0;  // frames that came after the step began
    while (auto frame = camera_->next()) {
      if (!begun) {
        begun = begins();
        begin_ns = monotonic_ns();
        if (!begun && ended_) break;
        continue;
      }
      if (frame->info().arrival_ns >= begin_ns) ++since;
      if (since < 2 || frame->info().status != FrameStatus::good) continue;
      frame->set_sequence(step_++);
      return frame;
    }
    return std::nullopt;
  }

 private:
  /// Whether the next step may begin.
  bool begins() {
    if (choice_.kind == StepChoice::Kind::interval) {
      const std::int64_t now = monotonic_ns();
      if (now < due_ns_) return false;
      due_ns_ = (due_ns_ == 0 ? now : due_ns_) + static_cast<std::int64_t>(choice_.interval_s * 1e9);
      return true;
    }
    read_lines();
    if (lines_ == 0) return false;
    --lines_;
    return true;
  }

  /// Counts the lines that have come, without waiting for any.
  void read_lines() {
    pollfd waiting{choice_.input, POLLIN, 0};
    while (!ended_ && ::poll(&waiting, 1, 0) > 0) {
      std::array<char, 256> text{};
      const ssize_t count = ::read(choice_.input, text.data(), text.size());
      if (count < 0 && errno == EINTR) continue;
      ended_ = count <= 0;
      if (count > 0) lines_ += static_cast<std::size_t>(std::count(text.begin(), text.begin() + count, '\n'));
    }
  }

  std::unique_ptr<FrameSource> camera_;
  StepChoice choice_;
  std::uint64_t step_ = 0;
  std::int64_t due_ns_ = 0;
  std::size_t lines_ = 0;
  bool ended_ = false;
};

}  // namespace

std::unique_ptr<FrameSource> open_stepped(std::unique_ptr<FrameSource> camera, StepChoice choice) {
  if (choice.kind == StepChoice::Kind::every) return camera;
  return std::make_unique<SteppedSource>(std::move(camera), std::move(choice));
}

}  // namespace vsfind
