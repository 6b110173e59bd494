#pragma once
/// @file
/// What the two threads of a lane do: take frames from the source, and search them.

#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "acquisition/buffer_pool.h"
#include "app/bounded_queue.h"
#include "app/counted_fault.h"
#include "app/pipeline.h"

namespace vsfind {

/// A result on its way to the output, with a copy of its frame where that is recorded.
struct LaneResult {
  FrameResult result;
  std::size_t lane = 0;
  std::optional<Frame> recorded;
  std::shared_ptr<const SourceInfo> info;
};

class LaneRun {
 public:
  LaneRun(const Lane& lane, std::size_t index, const PipelineOptions& options);

  /// Until the source ends. Throws what the source throws.
  void capture();
  /// Until nothing comes any more or `results` is closed.
  void search(BoundedQueue<LaneResult>& results);

  /// Lets go of a source that nobody wants frames of any more.
  void abort();
  /// No further frames; those that wait are still searched.
  void stop() const { lane_.source->stop(); }
  void end_of_capture() { frames_.close(); }

  /// After the end of both threads.
  [[nodiscard]] std::uint64_t dropped() const { return dropped_.total(); }
  [[nodiscard]] std::uint64_t lost() const { return lost_.total(); }

 private:
  struct Captured {
    Frame frame;
    std::shared_ptr<const SourceInfo> info;
  };

  void watch(const Frame& frame);
  void adopt(const std::shared_ptr<const SourceInfo>& info);
  FrameResult result_of(const Frame& frame);
  std::optional<Frame> copy_of(const Frame& frame);

  Lane lane_;
  std::size_t index_;
  std::string name_;
  std::optional<std::uint64_t> max_frames_;
  std::size_t queue_length_;
  BoundedQueue<Captured> frames_;

  // of the capturing thread
  std::optional<std::uint64_t> last_sequence_;
  CountedFault dropped_;
  CountedFault lost_;
  CountedFault bad_;
  std::chrono::steady_clock::time_point next_statistics_;

  // of the searching thread
  std::shared_ptr<const SourceInfo> info_;
  std::shared_ptr<BufferPool> copies_;
  bool searched_once_ = false;
  CountedFault refused_;
};

}  // namespace vsfind
