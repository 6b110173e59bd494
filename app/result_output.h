#pragma once
/// @file
/// The output stage: rows, overlays, summary and progress of every frame's result.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/frame_searcher.h"
#include "app/overlay.h"
#include "app/progress.h"
#include "app/report/run_report.h"
#include "app/row_writer.h"
#include "app/run_options.h"
#include "app/summary.h"

namespace vsfind {

class ResultOutput {
 public:
  /// Opens the files. Throws IoError. `total_frames` is for the progress bar, where it is known.
  ResultOutput(const RunOptions& options, std::vector<std::shared_ptr<const Pattern>> patterns,
               std::optional<std::uint64_t> total_frames);

  /// Writes a frame's rows (and pictures, drawn through `mapping`), each row's latency counted to now.
  /// Throws IoError.
  void put(const FrameResult& result, const SourceMapping& mapping);

  /// Takes the progress bar away before another line on stderr.
  void clear_progress() { progress_.clear(); }

  /// Counts frames that were never searched.
  void count_dropped(std::uint64_t frames) { summary_.dropped += frames; }

  [[nodiscard]] const Summary& summary() const { return summary_; }

  /// Writes the report, where one is asked for. Throws IoError.
  void write_report() const;

  /// Ends the progress bar and prints the summary on stderr, unless --quiet or nothing came. Never throws.
  void finish() noexcept;

 private:
  std::vector<std::shared_ptr<const Pattern>> patterns_;
  std::vector<std::unique_ptr<RowWriter>> writers_;
  std::optional<OverlayWriter> overlay_;
  std::optional<RunReport> report_;
  Progress progress_;
  Summary summary_;
};

/// CLOCK_MONOTONIC, as FrameInfo::arrival_ns.
[[nodiscard]] std::int64_t monotonic_ns();

}  // namespace vsfind
