#include "app/record_run.h"

#include <fmt/format.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "acquisition/errors.h"
#include "acquisition/recording.h"
#include "app/bounded_queue.h"

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

bool same_shape(const SourceInfo& a, const SourceInfo& b) {
  return a.width == b.width && a.height == b.height && a.bits == b.bits;
}

}  // namespace

Recorded record(FrameSource& source, const std::string& path, const RecordLimits& limits, SignalWatcher& signals,
                const std::function<void(std::uint64_t)>& progress) {
  // What waits here is bounded by the source's own buffers: it waits itself when all of them are lent.
  constexpr std::size_t never_full = 1U << 20U;
  BoundedQueue<Frame> frames(never_full);
  SourceInfo shape;           // written before the first frame is queued, read after it is taken
  std::exception_ptr failed;  // of the source; read after the capture thread's end
  Recorded result;
  signals.on_signal([&source] { source.stop(); });
  {
    const std::jthread capture([&] {
      std::optional<StopTimer> timer;
      try {
        std::uint64_t count = 0;
        while (auto frame = source.next()) {
          if (count == 0) {
            shape = source.info();
            if (limits.seconds > 0) timer.emplace(source, limits.seconds);
          } else if (!same_shape(shape, source.info())) {
            throw CameraError(fmt::format("{}: now gives {}x{} pixels of {} bits, the recording has {}x{} of {}",
                                          source.info().name, source.info().width, source.info().height,
                                          source.info().bits, shape.width, shape.height, shape.bits));
          }
          if (!frames.push(std::move(*frame)) || ++count == limits.frames) break;
        }
      } catch (...) {
        failed = std::current_exception();
      }
      frames.close();  // what waits is still written
    });
    try {
      std::optional<RecordingWriter> writer;
      std::uint64_t next_sequence = 0;
      std::int64_t first_arrival = 0;
      while (const auto frame = frames.pop()) {
        const FrameInfo& info = frame->info();
        if (!writer) {
          writer.emplace(path, shape);
          first_arrival = info.arrival_ns;
          next_sequence = info.sequence;
        }
        writer->append(*frame);
        result.frames = writer->frames();
        result.bytes = writer->bytes();
        result.seconds = static_cast<double>(info.arrival_ns - first_arrival) / 1e9;
        if (info.status != FrameStatus::good) ++result.bad;
        if (info.sequence > next_sequence) result.gaps += info.sequence - next_sequence;
        next_sequence = info.sequence + 1;
        progress(result.frames);
      }
      if (writer) writer->close();
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
