#include "tests/soak/ledger.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "acquisition/errors.h"
#include "acquisition/recording.h"
#include "tests/app/shell.h"

namespace vsfind::test {
namespace {

constexpr const char* pose_columns[] = {"score",   "x",       "y",       "angle_deg", "scale_x",
                                        "scale_y", "image_x", "image_y", "visible"};
constexpr std::size_t most_faults = 20;

/// A picture without what lies between its rows.
std::vector<std::byte> pixels_of(const ImageView& image) {
  std::vector<std::byte> pixels;
  const auto row = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.bytes_per_pixel());
  for (int y = 0; y < image.height; ++y) {
    const std::byte* from = image.data + y * image.stride;
    pixels.insert(pixels.end(), from, from + row);
  }
  return pixels;
}

/// Both ways of writing give the same digits, so a number is compared as the number that it is.
std::string number_text(double value) { return fmt::format("{};", value); }

}  // namespace

std::optional<SoakRow> row_of_json(const std::string& line) {
  const auto json = nlohmann::json::parse(line, nullptr, false);
  if (!json.is_object() || !json.contains("frame") || !json.contains("timed_out")) return std::nullopt;
  SoakRow row;
  row.frame = json["frame"].get<std::uint64_t>();
  row.status = json["status"].get<std::string>();
  for (const char* column : pose_columns) {
    row.pose += json[column].is_number() ? number_text(json[column].get<double>()) : ";";
  }
  return row;
}

std::optional<SoakRow> row_of_csv(const std::string& line, const std::vector<std::string>& header) {
  const auto cells = csv_cells(line);
  if (cells.size() != header.size() || cells.back().empty()) return std::nullopt;
  const auto cell = [&](const std::string& column) {
    return cells[static_cast<std::size_t>(std::find(header.begin(), header.end(), column) - header.begin())];
  };
  SoakRow row;
  row.frame = std::strtoull(cell("frame").c_str(), nullptr, 10);
  row.status = cell("status");
  for (const char* column : pose_columns) {
    const std::string text = cell(column);
    row.pose += text.empty() ? ";" : number_text(std::strtod(text.c_str(), nullptr));
  }
  return row;
}

std::optional<SoakSummary> summary_in(const std::string& log) {
  SoakSummary told;
  bool summed_up = false;
  std::stringstream lines(log);
  const auto before = [](const std::string& line, const std::string& words) -> std::uint64_t {
    const auto at = line.find(words);
    if (at == std::string::npos || at == 0) return 0;
    const auto begin = line.find_last_not_of("0123456789", at - 1);
    return std::strtoull(line.c_str() + (begin == std::string::npos ? 0 : begin + 1), nullptr, 10);
  };
  for (std::string line; std::getline(lines, line);) {
    if (line.find(" frames: ") != std::string::npos && line.find(" not found, ") != std::string::npos) {
      summed_up = true;
      told.frames = before(line, " frames: ");
      told.bad = before(line, " bad");
      told.dropped = before(line, " dropped");
      told.lost = before(line, " lost before they came");
    }
    if (line.find("rows, pictures or recorded frames could not be written") != std::string::npos)
      told.unwritten = before(line, " rows, pictures");
    if (const auto at = line.find("reopened "); at != std::string::npos)
      told.reopened = std::strtoull(line.c_str() + at + std::strlen("reopened "), nullptr, 10);
  }
  return summed_up ? std::optional(told) : std::nullopt;
}

void Ledger::fault(const std::string& what) {
  if (faults_.size() < most_faults) faults_.push_back(what);
}

void Ledger::add(const std::string& line) {
  const auto row = row_of_json(line);
  if (!row) {
    fault("a torn row: '" + line + "'");
    return;
  }
  if (last_ && row->frame > *last_ + 1) gaps_ += row->frame - *last_ - 1;
  if (!last_) gaps_ += row->frame;
  if (last_ && row->frame <= *last_) {
    // The number of a broken frame is a guess.
    ++repeated_;
    if (row->status != "bad_frame" && rows_.contains(row->frame) &&
        rows_.find(row->frame)->second.status != "bad_frame")
      fault(fmt::format("frame {} came twice", row->frame));
  }
  last_ = std::max(row->frame, last_.value_or(0));
  rows_.emplace(row->frame, *row);
  if (row->status == "bad_frame") {
    ++bad_;
    return;
  }
  follow(*row);
}

/// The pictures are shown in turn, so as many frames on there must be the picture as many places on.
void Ledger::follow(const SoakRow& row) {
  std::vector<std::size_t> now;
  for (std::size_t i = 0; i < served_.size(); ++i) {
    if (served_[i].status == row.status && served_[i].pose == row.pose) now.push_back(i);
  }
  if (now.empty())
    fault(fmt::format("frame {}: a row of no picture that was served: {} {}", row.frame, row.status, row.pose));
  if (last_good_ && row.frame > *last_good_) {
    const std::size_t step = (row.frame - *last_good_) % served_.size();
    std::vector<std::size_t> expected;
    for (const std::size_t phase : phases_) {
      const std::size_t next = (phase + step) % served_.size();
      if (std::find(now.begin(), now.end(), next) != now.end()) expected.push_back(next);
    }
    if (expected.empty()) {
      ++breaks_;
      where_broken_ += fmt::format(", from frame {} (picture {}) to {} ({})", *last_good_, fmt::join(phases_, "/"),
                                   row.frame, fmt::join(now, "/"));
    } else {
      now = expected;
    }
  }
  last_good_ = row.frame;
  phases_ = now;
}

void Ledger::compare_csv(const std::string& text) {
  if (text.empty() || text.back() != '\n') fault("the rows on the disk end within a line");
  std::stringstream lines(text);
  std::string line;
  std::getline(lines, line);
  const auto header = csv_cells(line);
  std::uint64_t count = 0;
  while (std::getline(lines, line)) {
    const auto row = row_of_csv(line, header);
    if (!row) {
      fault("a torn row on the disk: '" + line + "'");
      continue;
    }
    ++count;
    const auto [begin, end] = rows_.equal_range(row->frame);
    if (std::none_of(begin, end, [&](const auto& other) { return other.second == *row; }))
      fault(fmt::format("frame {}: the row on the disk differs from that of the pipe", row->frame));
  }
  if (count > rows_.size()) fault("there are more rows on the disk than in the pipe");
  missing_rows_ = rows_.size() - std::min<std::uint64_t>(count, rows_.size());
}

void Ledger::compare_recording(const std::string& path, const std::string& served_recording) {
  std::vector<std::vector<std::byte>> pictures;
  const auto served = open_y4m(served_recording);
  while (const auto frame = served->next()) pictures.push_back(pixels_of(frame->image()));
  try {
    const auto recorded = open_y4m(path);
    while (const auto frame = recorded->next()) {
      ++recorded_;
      const std::uint64_t number = frame->info().sequence;
      const auto [begin, end] = rows_.equal_range(number);
      if (begin == end) fault(fmt::format("frame {} was recorded but has no row", number));
      if (frame->info().status != FrameStatus::good) continue;
      const auto pixels = pixels_of(frame->image());
      const auto picture = std::find(pictures.begin(), pictures.end(), pixels);
      if (picture == pictures.end()) {
        fault(fmt::format("frame {} as recorded is no picture that was served", number));
        continue;
      }
      const SoakRow& wanted = served_[static_cast<std::size_t>(picture - pictures.begin())];
      if (std::none_of(begin, end, [&](const auto& row) { return row.second.pose == wanted.pose; }))
        fault(fmt::format("frame {}: the row is not that of the picture recorded", number));
    }
  } catch (const IoError& error) {
    fault(error.what());
  }
  if (recorded_ > rows_.size()) fault("more frames were recorded than searched");
  missing_frames_ = rows_.size() - std::min<std::uint64_t>(recorded_, rows_.size());
}

void Ledger::hear_complaints(const std::string& log) {
  // Where a camera dies while its description is read, Aravis 0.8.26 takes the name that did not come for a file's.
  constexpr std::array expected{"g_ascii_strcasecmp: assertion 's1 != NULL' failed",
                                "g_file_get_contents: assertion 'filename != NULL' failed"};
  std::istringstream lines(log);
  for (std::string line; std::getline(lines, line);) {
    if (line.find("camera library: ") == std::string::npos) continue;
    ++complaints_;
    const bool known = std::any_of(expected.begin(), expected.end(),
                                   [&](const char* each) { return line.find(each) != std::string::npos; });
    if (!known) fault("complaint of the camera library: " + line);
  }
}

void Ledger::settle(const std::string& log, int exit_code) {
  for (const char* word : {"AddressSanitizer", "LeakSanitizer", "ThreadSanitizer", "runtime error:", "CRITICAL"}) {
    if (log.find(word) != std::string::npos) fault(std::string("the log holds '") + word + "'");
  }
  hear_complaints(log);
  const auto told = summary_in(log);
  if (!told) {
    fault("there is no closing summary");
    return;
  }
  told_ = *told;
  if (told_.frames != rows_.size()) fault(fmt::format("{} frames are told, {} rows came", told_.frames, rows_.size()));
  if (told_.bad != bad_) fault(fmt::format("{} bad frames are told, {} came", told_.bad, bad_));
  // A broken frame under another one's number leaves no gap where it is dropped.
  const std::uint64_t told_missing = told_.lost + told_.dropped;
  if (gaps_ > told_missing || told_missing - gaps_ > told_.reopened + repeated_)
    fault(fmt::format("{} frames are missing, {} lost and {} dropped are told", gaps_, told_.lost, told_.dropped));
  if (breaks_ > told_.reopened)
    fault(fmt::format("the pictures' order begins anew {} times, {} returns are told{}", breaks_, told_.reopened,
                      where_broken_));
  if (told_.unwritten != missing_rows_ + missing_frames_)
    fault(fmt::format("{} rows and {} recorded frames are missing on the disk, {} are told", missing_rows_,
                      missing_frames_, told_.unwritten));
  const int expected = told_.unwritten > 0 ? 3 : 0;
  if (exit_code != expected) fault(fmt::format("exit code {} instead of {}", exit_code, expected));
}

std::string Ledger::text() const {
  return fmt::format(
      "{} rows, {} of them bad frames; {} frames missing: {} lost before they came, {} dropped; camera back {} times; "
      "{} rows and {} frames lost to the full disk, {} frames recorded; {} complaints of the camera library; {} faults",
      rows_.size(), bad_, gaps_, told_.lost, told_.dropped, told_.reopened, missing_rows_, missing_frames_, recorded_,
      complaints_, faults_.size());
}

}  // namespace vsfind::test
