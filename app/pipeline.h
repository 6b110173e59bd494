#pragma once
/// @file
/// Capture, search and output, each on a thread of its own, connected by bounded queues.

#include <cstddef>
#include <exception>

#include "acquisition/source.h"
#include "app/frame_searcher.h"
#include "app/result_output.h"
#include "app/signals.h"

namespace vsfind {

struct PipelineOptions {
  std::size_t queue_length = 4;  ///< frames that may wait for the search, and results that may wait for the output
  bool drop_oldest = false;      ///< a full queue loses its oldest frame (live) instead of making the source wait
};

/// Runs until the source ends, is stopped, or something fails. Rows come in the order of the frames. Everything that
/// was captured before an end or a failure of the source is searched and written. While it runs a signal stops the
/// source. Gives the first failure, or nothing.
[[nodiscard]] std::exception_ptr run_pipeline(FrameSource& source, FrameSearcher& searcher, ResultOutput& output,
                                              SignalWatcher& signals, const PipelineOptions& options = {});

}  // namespace vsfind
