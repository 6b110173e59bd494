#pragma once
/// @file
/// Records what a live source gave to the search, for months: a full disk or a camera that changes its size does not
/// end the run.

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "acquisition/recording.h"

namespace vsfind {

class Recorder {
 public:
  /// Creates or empties the file; its header is written with the first frame. Throws IoError.
  explicit Recorder(std::string path);

  /// Appends a frame of a source that is as `info` says. Where the frames change their size (fit_one_recording()), a
  /// further file is begun: "FILE-2.y4m". A frame that cannot be written is counted, told of once, and left out; after
  /// a growing pause it is tried again.
  void append(const Frame& frame, const SourceInfo& info);

  /// Ends the file. Never throws: what fails is counted as a lost frame.
  void close() noexcept;

  /// Frames that could not be written.
  [[nodiscard]] std::uint64_t lost() const { return lost_; }

 private:
  std::string path_;
  int files_ = 0;
  std::optional<SourceInfo> info_;  // of the file being written
  std::optional<RecordingWriter> writer_;
  std::uint64_t lost_ = 0;
  std::uint64_t lost_in_a_row_ = 0;
  std::chrono::steady_clock::time_point next_attempt_;
  std::chrono::milliseconds pause_{0};
};

}  // namespace vsfind
