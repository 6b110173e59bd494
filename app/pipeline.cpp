#include "app/pipeline.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>

#include "app/bounded_queue.h"
#include "app/lane_run.h"

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

/// Calls a function after some time, unless it is destroyed before.
class Alarm {
 public:
  Alarm(double seconds, std::function<void()> action)
      : thread_([this, seconds, action = std::move(action)](const std::stop_token& stop) {
          std::unique_lock lock(mutex_);
          const auto time = std::chrono::duration<double>(seconds);
          ends_.wait_for(lock, stop, time, [] { return false; });
          if (!stop.stop_requested()) action();
        }) {}

 private:
  std::mutex mutex_;
  std::condition_variable_any ends_;
  std::jthread thread_;  // the last member: it goes first
};

}  // namespace

std::exception_ptr run_pipeline(std::vector<Lane> lanes, ResultOutput& output, SignalWatcher& signals,
                                const PipelineOptions& options) {
  std::vector<std::unique_ptr<LaneRun>> runs;
  for (std::size_t i = 0; i < lanes.size(); ++i) runs.push_back(std::make_unique<LaneRun>(lanes[i], i, options));
  BoundedQueue<LaneResult> results(options.queue_length);
  FirstError error;
  std::atomic<std::size_t> searching = runs.size();
  const auto stop_all = [&runs] {
    for (const auto& run : runs) run->stop();
  };
  const auto abort_all = [&runs] {
    for (const auto& run : runs) run->abort();
  };
  signals.on_signal(stop_all);
  {
    std::optional<Alarm> alarm;
    if (options.max_seconds) alarm.emplace(*options.max_seconds, stop_all);
    spdlog::default_logger_raw();  // made before there are threads, not by the first that has something to say
    std::vector<std::jthread> threads;
    for (const auto& owner : runs) {
      LaneRun* const run = owner.get();
      threads.emplace_back([&, run] {
        try {
          run->capture();
        } catch (...) {
          error.set(std::current_exception());
          stop_all();  // of several sources, the others end with it
        }
        run->end_of_capture();  // what waits is still searched
      });
      threads.emplace_back([&, run] {
        try {
          run->search(results);
        } catch (...) {
          error.set(std::current_exception());
          run->abort();
          stop_all();
        }
        if (--searching == 0) results.close();  // what was found is still written
      });
    }
    threads.emplace_back([&] {
      try {
        while (const auto result = results.pop()) {
          output.put(result->result);
          Recorder* const recorder = lanes[result->lane].recorder;
          if (recorder != nullptr && result->recorded) recorder->append(*result->recorded, *result->info);
        }
      } catch (...) {
        error.set(std::current_exception());
        results.abort();
        abort_all();
      }
    });
    threads.clear();  // waits for all of them, and the alarm goes
  }
  signals.on_signal({});
  for (const auto& run : runs) output.count_unsearched(run->dropped(), run->lost());
  try {
    output.write_report();
  } catch (...) {
    error.set(std::current_exception());
  }
  return error.get();
}

std::exception_ptr run_pipeline(FrameSource& source, FrameSearcher& searcher, ResultOutput& output,
                                SignalWatcher& signals, const PipelineOptions& options) {
  Lane lane;
  lane.source = &source;
  lane.searcher = &searcher;
  lane.drop_oldest = options.drop_oldest;
  return run_pipeline({lane}, output, signals, options);
}

}  // namespace vsfind
