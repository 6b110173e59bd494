#include "app/evaluate/truth_file.h"

#include <fmt/format.h>

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <string_view>

#include "acquisition/errors.h"

namespace vsfind {
namespace {

constexpr std::size_t max_bytes = std::size_t{64} << 20U;
constexpr std::size_t most_columns = 256;

/// A complaint's own copy of foreign text: short, on one line.
std::string shown_cell(std::string_view text) {
  std::string copy;
  for (const char c : text.substr(0, 40)) copy += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;
  return "'" + copy + (text.size() > 40 ? "...'" : "'");
}

/// The next record of RFC 4180: cells may be quoted, and then hold commas, quotes (doubled) and line breaks.
class CsvReader {
 public:
  CsvReader(std::string_view text, const std::string& file) : text_(text), file_(file) {
    if (text_.starts_with("\xef\xbb\xbf")) text_.remove_prefix(3);
  }

  /// False at the end.
  bool next(std::vector<std::string>& cells) {
    cells.clear();
    if (at_ >= text_.size()) return false;
    line_ = next_line_;
    cells.emplace_back();
    for (bool quoted = false; at_ < text_.size(); ++at_) {
      const char c = text_[at_];
      if (c == '\n') ++next_line_;
      if (quoted) {
        if (c != '"') {
          cells.back() += c;
        } else if (at_ + 1 < text_.size() && text_[at_ + 1] == '"') {
          cells.back() += '"';
          ++at_;
        } else {
          quoted = false;
        }
      } else if (c == '"' && cells.back().empty()) {
        quoted = true;
      } else if (c == ',') {
        if (cells.size() == most_columns) {
          throw UsageError(fmt::format("{}:{}: has too many columns (allowed: {})", file_, line_, most_columns));
        }
        cells.emplace_back();
      } else if (c == '\n') {
        ++at_;
        break;
      } else {
        cells.back() += c;
      }
    }
    if (!cells.back().empty() && cells.back().back() == '\r') cells.back().pop_back();
    return true;
  }
  [[nodiscard]] int line() const { return line_; }

 private:
  std::string_view text_;
  const std::string& file_;
  std::size_t at_ = 0;
  int line_ = 0;
  int next_line_ = 1;
};

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

/// Cells of one record by their column.
class Record {
 public:
  Record(const std::map<std::string, std::size_t>& columns, const std::vector<std::string>& cells,
         const std::string& file, int line)
      : columns_(columns), cells_(cells), file_(file), line_(line) {}

  /// "" where there is no such column, or nothing in it.
  [[nodiscard]] std::string_view text(const std::string& column) const {
    const auto place = columns_.find(column);
    return place == columns_.end() || place->second >= cells_.size() ? std::string_view{}
                                                                     : trimmed(cells_[place->second]);
  }
  [[noreturn]] void fail(const std::string& column, const std::string& what) const {
    throw UsageError(fmt::format("{}:{}: {}: {}", file_, line_, column, what));
  }
  [[nodiscard]] std::optional<double> number(const std::string& column, double min, double max) const {
    const std::string_view cell = text(column);
    if (cell.empty()) return std::nullopt;
    double value = 0.0;
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    if (error != std::errc{} || end != cell.data() + cell.size() || !(value >= min && value <= max)) {
      fail(column, fmt::format("{} is not a number from {:g} to {:g}", shown_cell(cell), min, max));
    }
    return value;
  }

 private:
  const std::map<std::string, std::size_t>& columns_;
  const std::vector<std::string>& cells_;
  const std::string& file_;
  int line_;
};

TruthRow row_of(const Record& record, bool in_frame_pixels, int line) {
  TruthRow row;
  row.line = line;
  const std::string_view frame = record.text("frame");
  const auto [end, error] = std::from_chars(frame.data(), frame.data() + frame.size(), row.frame);
  if (frame.empty() || error != std::errc{} || end != frame.data() + frame.size()) {
    record.fail("frame", shown_cell(frame) + " is not the number of a frame (allowed: a whole number from 0)");
  }
  const std::string_view field = record.text("field");
  if (field == "top" || field == "bottom" || field == "frame") {
    row.field = field == "top" ? Field::top : field == "bottom" ? Field::bottom : Field::frame;
  } else if (!field.empty()) {
    record.fail("field", shown_cell(field) + " is not known (allowed: frame, top, bottom, or nothing)");
  }
  row.model = record.text("model");
  const std::string_view status = record.text("status");
  if (!status.empty() && status != "found" && status != "not_found" && status != "bad_frame") {
    record.fail("status", shown_cell(status) + " is not known (allowed: found, not_found, bad_frame, or nothing)");
  }
  constexpr double far = 1e9;
  const char* const column_x = in_frame_pixels ? "image_x" : "x";
  const char* const column_y = in_frame_pixels ? "image_y" : "y";
  const auto x = record.number(column_x, -far, far);
  const auto y = record.number(column_y, -far, far);
  if (x.has_value() != y.has_value()) record.fail(x ? column_y : column_x, "is missing beside the other coordinate");
  row.angle_deg = record.number("angle_deg", -1e6, 1e6);
  row.scale_x = record.number("scale_x", 1e-3, 1e3);
  row.scale_y = record.number("scale_y", 1e-3, 1e3);
  row.present = x.has_value() && (status.empty() || status == "found");
  if (status == "found" && !x) record.fail(column_x, "is missing where the status is found");
  row.x = x.value_or(0.0);
  row.y = y.value_or(0.0);
  return row;
}

}  // namespace

TruthFile parse_truth(const std::string& text, const std::string& file) {
  if (text.size() > max_bytes) throw UsageError(file + ": is larger than a list of truth may be (allowed: 64 MB)");
  CsvReader reader(text, file);
  std::vector<std::string> cells;
  std::map<std::string, std::size_t> columns;
  const auto is_blank = [](const std::vector<std::string>& record) {
    return record.size() == 1 && (trimmed(record[0]).empty() || trimmed(record[0]).front() == '#');
  };
  bool headed = false;
  while (!headed && reader.next(cells)) headed = !is_blank(cells);
  if (!headed) throw UsageError(file + ": is empty (allowed: CSV with the columns frame, x, y, and more)");
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (!columns.emplace(std::string(trimmed(cells[i])), i).second && !trimmed(cells[i]).empty()) {
      throw UsageError(fmt::format("{}:{}: the column {} stands twice", file, reader.line(), shown_cell(cells[i])));
    }
  }
  const auto has = [&](const char* column) { return columns.find(column) != columns.end(); };
  TruthFile truth;
  truth.in_frame_pixels = !(has("x") && has("y"));
  if (!has("frame") || (truth.in_frame_pixels && !(has("image_x") && has("image_y")))) {
    throw UsageError(fmt::format("{}:{}: the columns frame, and x, y or image_x, image_y are needed; there are {}",
                                 file, reader.line(), shown_cell(fmt::format("{}", fmt::join(cells, ",")))));
  }
  while (reader.next(cells)) {
    if (is_blank(cells)) continue;
    truth.rows.push_back(row_of(Record(columns, cells, file, reader.line()), truth.in_frame_pixels, reader.line()));
  }
  return truth;
}

TruthFile load_truth(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) throw IoError(path + ": is a folder (allowed: a CSV file)");
  std::ifstream file(path, std::ios::binary);
  if (!file) throw IoError(path + ": cannot be read: " + std::strerror(errno));
  std::string text;
  std::string block(std::size_t{1} << 16U, '\0');
  while (text.size() <= max_bytes &&
         (file.read(block.data(), static_cast<std::streamsize>(block.size())), file.gcount() > 0)) {
    text.append(block, 0, static_cast<std::size_t>(file.gcount()));
  }
  if (file.bad()) throw IoError(path + ": cannot be read: " + std::strerror(errno));
  return parse_truth(text, path);
}

}  // namespace vsfind
