#include "app/result_output.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <chrono>

#include "acquisition/errors.h"
#include "app/log.h"
#include "app/report/page.h"

namespace vsfind {

std::int64_t monotonic_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

ResultOutput::ResultOutput(const RunOptions& options, std::optional<std::uint64_t> total_frames,
                           const RowFileOptions& row_files)
    : report_folder_(options.report),
      keep_going_(row_files.keep_going),
      progress_(!log_is_quiet(), options.csv == "-" || options.jsonl == "-", total_frames) {
  // The folders first: where one cannot be made, no row file is emptied for nothing.
  if (!options.overlay.empty()) overlay_.emplace(options.overlay);
  if (!options.report.empty()) make_report_folder(options.report);
  if (!options.csv.empty()) writers_.push_back(std::make_unique<CsvWriter>(options.csv, row_files));
  if (!options.jsonl.empty()) writers_.push_back(std::make_unique<JsonlWriter>(options.jsonl, row_files));
}

void ResultOutput::put(const FrameResult& result) {
  constexpr double ms_per_ns = 1e-6;
  const auto write = [this](const ResultRow& row) {
    for (const auto& writer : writers_) writer->write(row);
  };
  const auto& patterns = *result.patterns;
  const SourceMapping& mapping = *result.mapping;
  ResultRow row;
  row.source = result.source;
  row.frame = result.info.sequence;
  row.timestamp_ns = result.info.timestamp_ns;
  row.unit = mapping.unit;
  row.latency_ms = static_cast<double>(monotonic_ns() - result.info.arrival_ns) * ms_per_ns;
  if (result.info.status != FrameStatus::good) {
    row.status = RowStatus::bad_frame;
    row.field = result.info.field;
    for (const auto& pattern : patterns) {
      row.model = pattern->name;
      write(row);
    }
  }
  for (const auto& picture : result.pictures) {
    row.field = picture.field;
    row.search_ms = picture.search_ms;
    for (std::size_t p = 0; p < picture.patterns.size(); ++p) {
      const auto& matches = picture.patterns[p].matches;
      row.model = patterns[p]->name;
      row.timed_out = picture.patterns[p].timed_out;
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
  summary_.latency_ms.add(row.latency_ms);
  if (overlay_) write_overlay(result);
  if (!report_folder_.empty()) report_of(result).add(result, mapping, row.latency_ms);
  progress_.update(summary_.frames);
}

RunReport& ResultOutput::report_of(const FrameResult& result) {
  if (reports_.size() <= result.source_index) reports_.resize(result.source_index + 1);
  std::unique_ptr<RunReport>& report = reports_[result.source_index];
  if (!report) {
    const std::string folder =
        result.source_index == 0 ? report_folder_ : fmt::format("{}/source{}", report_folder_, result.source_index + 1);
    report = std::make_unique<RunReport>(folder, *result.patterns);
  }
  return *report;
}

void ResultOutput::write_report() const {
  for (const auto& report : reports_) {
    if (report) report->write(summary_);
  }
}

void ResultOutput::write_overlay(const FrameResult& result) {
  try {
    overlay_->write(result, *result.patterns, result.mapping->mapping);
  } catch (const IoError& error) {
    if (!keep_going_) throw;
    if (lost_overlays_++ == 0) spdlog::error("{}; going on without", error.what());
  }
}

std::uint64_t ResultOutput::lost() const {
  std::uint64_t lost = lost_overlays_;
  for (const auto& writer : writers_) lost += writer->lost();
  return lost;
}

void ResultOutput::finish() noexcept {
  progress_.clear();
  if (log_is_quiet() || (summary_.frames == 0 && !summary_.shows_latency)) return;
  try {
    fmt::print(stderr, "vsfind: {}\n", summary_.text());
  } catch (...) {  // stderr is gone: nobody is there to be told
  }
}

}  // namespace vsfind
