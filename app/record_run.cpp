#include "app/record_run.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "acquisition/recording.h"
#include "app/bounded_queue.h"
#include "app/rotated_files.h"

namespace vsfind {
namespace {

/// Stops the source after a time, unless it goes before.
class StopTimer {
 public:
  StopTimer(FrameSource& source, double seconds)
      : thread_([this, &source, seconds] {
          std::unique_lock lock(mutex_);
          if (!ended_.wait_for(lock, std::chrono::duration<double>(seconds), [this] { return over_; })) source.stop();
        }) {}
  StopTimer(const StopTimer&) = delete;
  StopTimer& operator=(const StopTimer&) = delete;
  ~StopTimer() {
    {
      const std::lock_guard lock(mutex_);
      over_ = true;
    }
    ended_.notify_all();
    thread_.join();
  }

 private:
  std::mutex mutex_;
  std::condition_variable ended_;
  bool over_ = false;
  std::thread thread_;
};

/// A frame with what its source said of itself then.
struct Captured {
  Frame frame;
  std::shared_ptr<const SourceInfo> info;
};

/// The recording, and those that go on where the frames change their size.
class Recordings {
 public:
  explicit Recordings(std::string path) : path_(std::move(path)) {}

  void append(const Captured& captured) {
    if (captured.info != info_) {
      if (!info_ || !fit_one_recording(*info_, *captured.info)) begin(*captured.info);
      info_ = captured.info;
    }
    writer_->append(captured.frame);
  }
  void close() {
    if (!writer_) return;
    frames_ += writer_->frames();
    bytes_ += writer_->bytes();
    writer_->close();
    writer_.reset();
  }
  [[nodiscard]] std::uint64_t frames() const { return frames_ + (writer_ ? writer_->frames() : 0); }
  [[nodiscard]] std::uint64_t bytes() const { return bytes_ + (writer_ ? writer_->bytes() : 0); }

 private:
  void begin(const SourceInfo& info) {
    close();
    const std::string name = ++files_ == 1 ? path_ : numbered_name(path_, files_);
    if (files_ > 1)
      spdlog::warn("{}: now gives {}x{} pixels of {} bits, before {}x{} of {}; recording goes on in {}", info.name,
                   info.width, info.height, info.bits, info_->width, info_->height, info_->bits, name);
    writer_.emplace(name, info);
  }

  std::string path_;
  int files_ = 0;
  std::shared_ptr<const SourceInfo> info_;
  std::optional<RecordingWriter> writer_;
  std::uint64_t frames_ = 0;  // of the files before
  std::uint64_t bytes_ = 0;
};

}  // namespace

Recorded record(FrameSource& source, const std::string& path, const RecordLimits& limits, SignalWatcher& signals,
                const std::function<void(std::uint64_t)>& progress) {
  // What waits here is bounded by the source's own buffers: it waits itself when all of them are lent.
  constexpr std::size_t never_full = 1U << 20U;
  BoundedQueue<Captured> frames(never_full);
  std::exception_ptr failed;  // of the source; read after the capture thread's end
  Recorded result;
  signals.on_signal([&source] { source.stop(); });
  {
    const std::jthread capture([&] {
      std::optional<StopTimer> timer;
      try {
        std::shared_ptr<const SourceInfo> info;
        std::uint64_t count = 0;
        while (auto frame = source.next()) {
          if (count == 0 && limits.seconds > 0) timer.emplace(source, limits.seconds);
          if (!info || *info != source.info()) info = std::make_shared<const SourceInfo>(source.info());
          if (!frames.push({std::move(*frame), info}) || ++count == limits.frames) break;
        }
      } catch (...) {
        failed = std::current_exception();
      }
      frames.close();  // what waits is still written
    });
    try {
      Recordings recordings(path);
      std::uint64_t next_sequence = 0;
      std::int64_t first_arrival = 0;
      while (const auto captured = frames.pop()) {
        const FrameInfo& info = captured->frame.info();
        if (result.frames == 0) {
          first_arrival = info.arrival_ns;
          next_sequence = info.sequence;
        }
        recordings.append(*captured);
        result.frames = recordings.frames();
        result.bytes = recordings.bytes();
        result.seconds = static_cast<double>(info.arrival_ns - first_arrival) / 1e9;
        if (info.status != FrameStatus::good) ++result.bad;
        if (info.sequence > next_sequence) result.gaps += info.sequence - next_sequence;
        next_sequence = info.sequence + 1;
        progress(result.frames);
      }
      recordings.close();
    } catch (...) {
      result.error = std::current_exception();
      frames.abort();
      source.stop();
    }
  }
  signals.on_signal({});
  if (!result.error) result.error = failed;
  return result;
}

}  // namespace vsfind
