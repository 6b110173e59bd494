#pragma once
/// @file
/// A line of the results, and what it is made of.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/image_view.h"
#include "finder/search.h"

namespace vsfind {

enum class RowStatus {
  found,
  not_found,
  bad_frame,  ///< incomplete or corrupt: never searched
};
[[nodiscard]] constexpr const char* name(RowStatus status) {
  return status == RowStatus::found ? "found" : status == RowStatus::not_found ? "not_found" : "bad_frame";
}

struct ResultRow {
  std::string source;
  std::uint64_t frame = 0;
  std::int64_t timestamp_ns = 0;
  Field field = Field::frame;
  std::string model;
  RowStatus status = RowStatus::not_found;
  int instance = 0;  ///< from 0, best first; with `match` and `unit` meant only where found
  Match match;
  std::string unit;
  std::optional<double> search_ms;  ///< nothing for a bad frame
  double latency_ms = 0.0;
  bool timed_out = false;  ///< the search was cut short by its timeout
};

/// One column of a row: text as it stands in the CSV ("" where the row has nothing there), and what it is.
struct RowCell {
  enum class Kind { text, number, flag };  ///< a flag's text is 0 or 1
  const char* column;
  Kind kind;
  std::string text;
};

/// A fixed number of digits after the point; "" for what is no number; never "-0.000".
[[nodiscard]] std::string fixed(double value, int digits);

/// All columns in their order. The only place that knows order, names and number of digits.
[[nodiscard]] std::vector<RowCell> row_cells(const ResultRow& row);

}  // namespace vsfind
