#pragma once
/// @file
/// Capture, search and output, each on a thread of its own, connected by bounded queues. Of several sources each has
/// its own capture and search; the output is one.

#include <cstddef>
#include <cstdint>
#include <exception>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/source.h"
#include "app/frame_searcher.h"
#include "app/recorder.h"
#include "app/result_output.h"
#include "app/signals.h"

namespace vsfind {

/// One source with what searches it. All of it is used by the pipeline's threads while that runs.
struct Lane {
  FrameSource* source = nullptr;
  FrameSearcher* searcher = nullptr;
  Recorder* recorder = nullptr;         ///< of what is searched, where wanted
  std::optional<MappingChoice> follow;  ///< the mapping is made from this and what the source says, as it says it
  SearchOptions search;                 ///< whose region is checked against the source's frames
  bool drop_oldest = false;  ///< a full queue loses its oldest frame (live) instead of making the source wait
};

struct PipelineOptions {
  /// Frames that may wait for the search, of fast cameras more (frames_that_may_wait()), and results that may wait for
  /// the output.
  std::size_t queue_length = 4;
  bool drop_oldest = false;                   ///< of the single source of the short form
  std::optional<std::uint64_t> max_frames{};  ///< of each source; what comes after them is not searched
  std::optional<double> max_seconds{};        ///< then the sources are stopped, and what waits is still searched
};

/// Runs until all sources end, are stopped, or something fails. Rows of a source come in the order of its frames.
/// Everything that was captured before an end or a failure of a source is searched and written. While it runs a signal
/// stops the sources. A frame that a live source's search refuses after others were searched (it has another size now)
/// gives bad_frame rows instead of an end. Gives the first failure, or nothing.
[[nodiscard]] std::exception_ptr run_pipeline(std::vector<Lane> lanes, ResultOutput& output, SignalWatcher& signals,
                                              const PipelineOptions& options = {});

/// The same for one source.
[[nodiscard]] std::exception_ptr run_pipeline(FrameSource& source, FrameSearcher& searcher, ResultOutput& output,
                                              SignalWatcher& signals, const PipelineOptions& options = {});

}  // namespace vsfind
