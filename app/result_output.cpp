#include "app/result_output.h"

#include <fmt/format.h>

#include <chrono>

#include "app/log.h"

namespace vsfind {

std::int64_t monotonic_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

ResultOutput::ResultOutput(const RunOptions& options, std::vector<std::shared_ptr<const Pattern>> patterns,
                           std::optional<std::uint64_t> total_frames)
    : patterns_(std::move(patterns)),
      progress_(!log_is_quiet(), options.csv == "-" || options.jsonl == "-", total_frames) {
  // The folders first: where one cannot be made, no row file is emptied for nothing.
  if (!options.overlay.empty()) overlay_.emplace(options.overlay);
  if (!options.report.empty()) report_.emplace(options.report, patterns_);
  if (!options.csv.empty()) writers_.push_back(std::make_unique<CsvWriter>(options.csv));
  if (!options.jsonl.empty()) writers_.push_back(std::make_unique<JsonlWriter>(options.jsonl));
}

void ResultOutput::put(const FrameResult& result, const SourceMapping& mapping) {
  constexpr double ms_per_ns = 1e-6;
  const auto write = [this](const ResultRow& row) {
    for (const auto& writer : writers_) writer->write(row);
  };
  ResultRow row;
  row.source = result.source;
  row.frame = result.info.sequence;
  row.timestamp_ns = result.info.timestamp_ns;
  row.unit = mapping.unit;
  row.latency_ms = static_cast<double>(monotonic_ns() - result.info.arrival_ns) * ms_per_ns;
  if (result.info.status != FrameStatus::good) {
    row.status = RowStatus::bad_frame;
    row.field = result.info.field;
    for (const auto& pattern : patterns_) {
      row.model = pattern->name;
      write(row);
    }
  }
  for (const auto& picture : result.pictures) {
    row.field = picture.field;
    row.search_ms = picture.search_ms;
    for (std::size_t p = 0; p < picture.patterns.size(); ++p) {
      const auto& matches = picture.patterns[p].matches;
      row.model = patterns_[p]->name;
      row.status = matches.empty() ? RowStatus::not_found : RowStatus::found;
      row.instance = 0;
      if (matches.empty()) write(row);
      for (const auto& match : matches) {
        row.match = match;
        write(row);
        ++row.instance;
      }
    }
  }
  summary_.add(result);
  if (overlay_) overlay_->write(result, patterns_, mapping.mapping);
  if (report_) report_->add(result, mapping, row.latency_ms);
  progress_.update(summary_.frames);
}

void ResultOutput::write_report() const {
  if (report_) report_->write(summary_);
}

void ResultOutput::finish() noexcept {
  progress_.clear();
  if (log_is_quiet() || summary_.frames == 0) return;
  try {
    fmt::print(stderr, "vsfind: {}\n", summary_.text());
  } catch (...) {  // stderr is gone: nobody is there to be told
  }
}

}  // namespace vsfind
