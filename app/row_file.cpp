#include "app/row_file.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <filesystem>
#include <utility>

#include "acquisition/errors.h"
#include "app/rotated_files.h"

namespace vsfind {
namespace {

std::tm local(std::time_t time) {
  std::tm parts{};
  ::localtime_r(&time, &parts);
  return parts;
}

std::time_t next_midnight(std::time_t time) {
  std::tm parts = local(time);
  ++parts.tm_mday;
  parts.tm_hour = parts.tm_min = parts.tm_sec = 0;
  parts.tm_isdst = -1;
  return std::mktime(&parts);
}

std::time_t time_of(const std::string& path) {
  const auto written = std::chrono::file_clock::to_sys(std::filesystem::last_write_time(path));
  return std::chrono::system_clock::to_time_t(
      std::chrono::time_point_cast<std::chrono::system_clock::duration>(written));
}

}  // namespace

RowFile::RowFile(std::string path, std::string header, RowFileOptions options)
    : path_(std::move(path)), header_(std::move(header)), options_(std::move(options)) {
  if (path_ != "-" && options_.rotates()) {
    try {
      if (std::filesystem::is_regular_file(path_) && std::filesystem::file_size(path_) > 0)
        rotate_away(path_, time_of(path_));
    } catch (const std::filesystem::filesystem_error& error) {
      throw IoError(fmt::format("{}: cannot be rotated away: {}", path_, error.code().message()));
    }
  }
  begin();
}

void RowFile::begin() {
  file_.emplace(path_);
  begun_ = options_.now();
  ends_ = next_midnight(begun_);
  bytes_ = 0;
  if (path_ != "-" && options_.rotates() && options_.keep > 0) remove_rotated(path_, options_.keep);
  if (header_.empty()) return;
  file_->write_line(header_);
  bytes_ = header_.size() + 1;
}

bool RowFile::is_due(std::size_t more) const {
  if (path_ == "-") return false;
  const std::uint64_t empty = header_.empty() ? 0 : header_.size() + 1;
  if (options_.max_bytes > 0 && bytes_ > empty && bytes_ + more > options_.max_bytes) return true;
  return options_.daily && options_.now() >= ends_;
}

void RowFile::rotate() {
  try {
    if (std::filesystem::exists(path_)) rotate_away(path_, begun_);  // else somebody else has taken it away already
    begin();
  } catch (const std::exception& error) {
    // Rows go on into the old file, which is as good; the next attempt comes with the next day or as many bytes more.
    spdlog::warn("{}: cannot be rotated: {}", path_, error.what());
    bytes_ = 0;
    ends_ = next_midnight(options_.now());
  }
}

void RowFile::write_line(std::string_view line) {
  if (is_due(line.size() + 1)) rotate();
  try {
    file_->write_line(line);
    bytes_ += line.size() + 1;
  } catch (const IoError& error) {
    if (!options_.keep_going || path_ == "-") throw;
    ++lost_;
    if (lost_in_a_row_++ == 0) spdlog::error("{}; going on without", error.what());
    return;
  }
  if (lost_in_a_row_ > 0) {
    spdlog::warn("{}: can be written again; {} rows are missing", path_, lost_in_a_row_);
    lost_in_a_row_ = 0;
  }
}

}  // namespace vsfind
