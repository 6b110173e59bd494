#include "app/pipeline.h"

#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "app/bounded_queue.h"

namespace vsfind {
namespace {

/// The first failure of any stage.
class FirstError {
 public:
  void set(std::exception_ptr error) {
    const std::lock_guard lock(mutex_);
    if (!error_) error_ = std::move(error);
  }
  [[nodiscard]] std::exception_ptr get() const { return error_; }

 private:
  std::mutex mutex_;
  std::exception_ptr error_;
};

}  // namespace

std::exception_ptr run_pipeline(FrameSource& source, FrameSearcher& searcher, ResultOutput& output,
                                SignalWatcher& signals, const PipelineOptions& options) {
  BoundedQueue<Frame> frames(options.queue_length);
  BoundedQueue<FrameResult> results(options.queue_length);
  FirstError error;
  std::uint64_t dropped = 0;  // counted by the capture thread, read after its end
  const std::string name = source.info().name;
  signals.on_signal([&source] { source.stop(); });

  {
    const std::jthread capture([&] {
      try {
        while (auto frame = source.next()) {
          if (options.drop_oldest) {
            std::optional<Frame> lost;
            if (!frames.push_dropping_oldest(std::move(*frame), lost)) break;
            if (lost) ++dropped;
          } else if (!frames.push(std::move(*frame))) {
            break;
          }
        }
      } catch (...) {
        error.set(std::current_exception());
      }
      frames.close();  // what waits is still searched
    });

    const std::jthread search([&] {
      try {
        while (const auto frame = frames.pop()) {
          if (!results.push(searcher.search(name, frame->info(), frame->image()))) break;
        }
      } catch (...) {
        error.set(std::current_exception());
        frames.abort();
        source.stop();  // the capture thread may wait for a frame that nobody wants any more
      }
      results.close();  // what was found is still written
    });

    const std::jthread write([&] {
      try {
        while (const auto result = results.pop()) output.put(*result, searcher.mapping());
      } catch (...) {
        error.set(std::current_exception());
        results.abort();
        frames.abort();
        source.stop();
      }
    });
  }
  signals.on_signal({});
  output.count_dropped(dropped);
  try {
    output.write_report();
  } catch (...) {
    error.set(std::current_exception());
  }
  return error.get();
}

}  // namespace vsfind
