#include "acquisition/reconnecting_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <utility>

#include "acquisition/errors.h"

namespace vsfind {
namespace {

using Time = std::chrono::steady_clock;

/// How fast the frames of a camera come, from their numbers and arrivals since it was opened.
class FrameRate {
 public:
  void add(const FrameInfo& frame) {
    if (!first_) first_ = frame;
    last_ = frame;
  }
  /// Frames that fit between the last one and one that arrives then; 0 where the rate is not known.
  [[nodiscard]] std::uint64_t missed_until(std::int64_t arrival_ns) const {
    constexpr std::uint64_t enough = 8;
    if (!first_ || last_.sequence < first_->sequence + enough) return 0;
    const auto frames = static_cast<double>(last_.sequence - first_->sequence);
    const auto time = static_cast<double>(last_.arrival_ns - first_->arrival_ns);
    const auto away = static_cast<double>(arrival_ns - last_.arrival_ns);
    if (time <= 0.0 || away <= 0.0) return 0;
    return static_cast<std::uint64_t>(std::max(std::llround(away * frames / time) - 1, 0LL));
  }

 private:
  std::optional<FrameInfo> first_;
  FrameInfo last_;
};

class ReconnectingSource final : public FrameSource {
 public:
  ReconnectingSource(std::string name, std::function<std::unique_ptr<FrameSource>()> open,
                     const ReconnectOptions& options)
      : open_(std::move(open)), options_(options), pause_(options.first_pause) {
    info_.name = std::move(name);
    info_.live = true;
  }

  [[nodiscard]] const SourceInfo& info() const override { return info_; }

  std::optional<Frame> next() override {
    while (!stopped()) {
      try {
        if (!source_) open();
        std::optional<Frame> frame = source_->next();
        if (!frame) return std::nullopt;
        return counted_on(std::move(*frame));
      } catch (const CameraError& error) {
        lose(error.what());
      } catch (const UsageError& error) {
        if (!opened_once_) throw;
        lose(error.what());
      }
    }
    return std::nullopt;
  }

  void stop() noexcept override {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    if (source_) source_->stop();
    stop_.notify_all();
  }

  [[nodiscard]] std::string statistics() const override {
    std::string text = source_ ? source_->statistics() : last_statistics_;
    if (returns_ > 0) text += fmt::format("{}reopened {} times", text.empty() ? "" : ", ", returns_);
    return text;
  }

 private:
  [[nodiscard]] bool stopped() {
    const std::lock_guard lock(mutex_);
    return stopped_;
  }

  void open() {
    std::unique_ptr<FrameSource> source = open_();
    source->on_event([this](const SourceEvent& event) { report(event.kind, event.text); });
    info_ = source->info();
    opened_once_ = true;
    just_opened_ = true;
    const std::lock_guard lock(mutex_);
    source_ = std::move(source);
    if (stopped_) source_->stop();
  }

  Frame counted_on(Frame frame) {
    if (lost_since_) {
      const double seconds = std::chrono::duration<double>(Time::now() - *lost_since_).count();
      // The first return of a camera that was absent at the start is one, too.
      report(SourceEvent::Kind::recovered, fmt::format("{}: frames come again, after {:.1f} s", info_.name, seconds));
      if (last_) ++returns_;
      lost_since_.reset();
      pause_ = options_.first_pause;
    }
    if (std::exchange(just_opened_, false)) {
      if (last_) {
        const std::uint64_t missed = paced_ ? rate_.missed_until(frame.info().arrival_ns) : 0;
        // Its own count need not begin at 0.
        offset_ = *last_ + 1 + std::max<std::uint64_t>(missed, 1) - frame.info().sequence;
      }
      rate_ = {};
      paced_ = info_.frame_rate.known();
    }
    frame.set_sequence(frame.info().sequence + offset_);
    last_ = std::max(last_.value_or(0), frame.info().sequence);
    rate_.add(frame.info());
    return frame;
  }

  /// Lets go of the camera, tells of it once, and waits before the next attempt. Throws CameraError when it is time to
  /// give up.
  void lose(const std::string& why) {
    const auto now = Time::now();
    const bool was_open = source_ != nullptr;
    if (was_open) {
      last_statistics_ = source_->statistics();
      std::unique_ptr<FrameSource> gone;  // destroyed after the lock is let go
      const std::lock_guard lock(mutex_);
      gone.swap(source_);
    }
    if (!lost_since_) {
      lost_since_ = now;
      last_reason_ = why;
      report(SourceEvent::Kind::fault, fmt::format("{}; trying again until it is back", why));
    } else if (why != last_reason_) {
      last_reason_ = why;
      report(SourceEvent::Kind::note, why);
    }
    auto pause = pause_;
    if (options_.give_up_after) {
      const auto left = *lost_since_ + *options_.give_up_after - now;
      if (left <= Time::duration::zero())
        throw CameraError(fmt::format("{} (given up after {:.1f} s)", why,
                                      std::chrono::duration<double>(*options_.give_up_after).count()));
      pause = std::min(pause, std::chrono::ceil<std::chrono::milliseconds>(left));
    }
    pause_ = std::min(pause_ * 2, options_.longest_pause);
    std::unique_lock lock(mutex_);
    stop_.wait_for(lock, pause, [this] { return stopped_; });
  }

  std::function<std::unique_ptr<FrameSource>()> open_;
  ReconnectOptions options_;
  SourceInfo info_;
  std::chrono::milliseconds pause_;
  std::optional<Time::time_point> lost_since_;
  std::string last_reason_;
  std::string last_statistics_;
  bool opened_once_ = false;
  std::uint64_t returns_ = 0;
  std::optional<std::uint64_t> last_;  // as counted here
  std::uint64_t offset_ = 0;           // modulo 2^64, from its own count to ours
  bool just_opened_ = false;
  bool paced_ = false;  // its frames come at a rate of their own
  FrameRate rate_;      // since it was opened

  std::mutex mutex_;  // of stopped_, and of source_ where it changes or stop() looks at it
  std::condition_variable stop_;
  bool stopped_ = false;
  std::unique_ptr<FrameSource> source_;
};

}  // namespace

std::unique_ptr<FrameSource> open_reconnecting(std::string name, std::function<std::unique_ptr<FrameSource>()> open,
                                               const ReconnectOptions& options) {
  return std::make_unique<ReconnectingSource>(std::move(name), std::move(open), options);
}

}  // namespace vsfind
