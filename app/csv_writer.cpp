#include "app/row_writer.h"

namespace vsfind {
namespace {

std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

std::string csv_header() {
  std::string header;
  for (const auto& cell : row_cells({})) header += (header.empty() ? "" : ",") + std::string(cell.column);
  return header;
}

}  // namespace

CsvWriter::CsvWriter(const std::string& path, RowFileOptions options) : file_(path, csv_header(), std::move(options)) {}

void CsvWriter::write(const ResultRow& row) {
  std::string line;
  bool first = true;
  for (const auto& cell : row_cells(row)) {
    if (!first) line += ',';
    first = false;
    line += cell.kind == RowCell::Kind::text ? csv_cell(as_utf8(cell.text)) : cell.text;
  }
  file_.write_line(line);
}

}  // namespace vsfind
