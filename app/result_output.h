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
  ResultOutput(const RunOptions& options, std::optional<std::uint64_t> total_frames,
               const RowFileOptions& row_files = {});

  /// Writes a frame's rows and pictures, each row's latency counted to now. Throws IoError.
  void put(const FrameResult& result);

  /// Shows latencies in the summary, as of live sources.
  void show_latency() { summary_.shows_latency = true; }

  /// Rows and pictures that could not be written (RowFileOptions::keep_going).
  [[nodiscard]] std::uint64_t lost() const;

  /// Takes the progress bar away before another line on stderr.
  void clear_progress() { progress_.clear(); }

  /// Counts frames that were never searched: dropped by us, and lost before they came.
  void count_unsearched(std::uint64_t dropped, std::uint64_t lost) {
    summary_.dropped += dropped;
    summary_.lost += lost;
  }

  [[nodiscard]] const Summary& summary() const { return summary_; }

  /// Writes the report, where one is asked for. Throws IoError.
  void write_report() const;

  /// Ends the progress bar and prints the summary on stderr, unless --quiet or nothing came. Never throws.
  void finish() noexcept;

 private:
  void write_overlay(const FrameResult& result);
  RunReport& report_of(const FrameResult& result);

  std::vector<std::unique_ptr<RowWriter>> writers_;
  std::optional<OverlayWriter> overlay_;
  std::string report_folder_;
  std::vector<std::unique_ptr<RunReport>> reports_;  ///< one a source, made with its first frame
  bool keep_going_;
  std::uint64_t lost_overlays_ = 0;
  Progress progress_;
  Summary summary_;
};

/// CLOCK_MONOTONIC, as FrameInfo::arrival_ns.
[[nodiscard]] std::int64_t monotonic_ns();

}  // namespace vsfind
