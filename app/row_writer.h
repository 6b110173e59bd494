#pragma once
/// @file
/// Rows into files: CSV and JSON Lines. A row is one whole line, written at once.

#include <cstdint>
#include <string>
#include <utility>

#include "app/result_row.h"
#include "app/row_file.h"

namespace vsfind {

class RowWriter {
 public:
  RowWriter() = default;
  RowWriter(const RowWriter&) = delete;
  RowWriter& operator=(const RowWriter&) = delete;
  virtual ~RowWriter() = default;
  /// Throws IoError.
  virtual void write(const ResultRow& row) = 0;
  /// Rows that could not be written (RowFileOptions::keep_going).
  [[nodiscard]] virtual std::uint64_t lost() const = 0;
};

/// One header line, then a line per row. Texts with a comma, a quote or a line break are quoted as in RFC 4180.
class CsvWriter final : public RowWriter {
 public:
  explicit CsvWriter(const std::string& path, RowFileOptions options = {});
  void write(const ResultRow& row) override;
  [[nodiscard]] std::uint64_t lost() const override { return file_.lost(); }

 private:
  RowFile file_;
};

/// One object per line, keys in the order of the CSV's columns; null where the CSV has nothing.
class JsonlWriter final : public RowWriter {
 public:
  explicit JsonlWriter(const std::string& path, RowFileOptions options = {}) : file_(path, {}, std::move(options)) {}
  void write(const ResultRow& row) override;
  [[nodiscard]] std::uint64_t lost() const override { return file_.lost(); }

 private:
  RowFile file_;
};

/// The text with everything that is not UTF-8 replaced by U+FFFD.
[[nodiscard]] std::string as_utf8(const std::string& text);

}  // namespace vsfind
