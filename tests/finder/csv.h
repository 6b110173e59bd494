#pragma once
/// @file
/// Result tables read back, columns by name. No quoting: the fields that the tests read have no commas.

#include <algorithm>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace vsfind::test {

using CsvRow = std::map<std::string, std::string>;

inline std::vector<std::string> split_line(const std::string& line) {
  std::vector<std::string> fields;
  std::string field;
  std::istringstream stream(line);
  while (std::getline(stream, field, ',')) fields.push_back(field);
  if (!line.empty() && line.back() == ',') fields.emplace_back();
  return fields;
}

/// The rows of a CSV file, an empty list where it cannot be read. A row of a wrong length has the key "" set.
inline std::vector<CsvRow> read_csv(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  std::vector<CsvRow> rows;
  if (!std::getline(file, line)) return rows;
  const std::vector<std::string> header = split_line(line);
  while (std::getline(file, line)) {
    const std::vector<std::string> fields = split_line(line);
    CsvRow row;
    if (fields.size() != header.size()) row[""] = line;
    for (std::size_t i = 0; i < std::min(fields.size(), header.size()); ++i) row[header[i]] = fields[i];
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace vsfind::test
