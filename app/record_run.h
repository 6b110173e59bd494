#pragma once
/// @file
/// A source written to a recording, frame by frame.

#include <cstdint>
#include <exception>
#include <functional>
#include <string>

#include "acquisition/source.h"
#include "app/signals.h"

namespace vsfind {

struct RecordLimits {
  std::uint64_t frames = 0;  ///< pictures: frames, or single fields; 0: no limit
  double seconds = 0.0;      ///< from the first one; 0: no limit
};

struct Recorded {
  std::uint64_t frames = 0;  ///< written, bad ones included
  std::uint64_t bad = 0;
  std::uint64_t gaps = 0;  ///< numbers that are missing among the source's own
  std::uint64_t bytes = 0;
  double seconds = 0.0;      ///< from the first frame's arrival to the last one's
  std::exception_ptr error;  ///< why it ended early; what was captured until then is in the file
};

/// Writes every frame of `source` until it ends, a limit is reached, a signal comes, or something fails. Nothing is
/// dropped here: while the disk is slow, frames wait in the source's buffers. The file is made when the first frame is
/// there; no file without a frame. Where the frames change their size it goes on in "FILE-2.y4m". `progress` is told
/// how many are written.
[[nodiscard]] Recorded record(FrameSource& source, const std::string& path, const RecordLimits& limits,
                              SignalWatcher& signals, const std::function<void(std::uint64_t)>& progress);

}  // namespace vsfind
