#pragma once
/// @file
/// The experiment's results for people: tables on stdout, and a report with charts.

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/qualify/stage_analysis.h"
#include "app/source_mapping.h"

namespace vsfind {

/// One stage's test with one pattern.
struct StageTest {
  StageRun run;
  StageAnalysis analysis;
};

/// A line of the closing table: a model, tested on one stage or on both.
struct QualifyRow {
  std::string name;  ///< of the model
  int accuracy = 0;
  std::size_t points = 0;  ///< of the sub-pixel pose
  std::optional<StageTest> linear;
  std::optional<StageTest> rotary;
};

struct QualifyResults {
  std::string title;
  std::vector<QualifyRow> rows;  ///< charts show the last one
  SourceMapping mapping;
  std::vector<std::pair<std::string, std::string>> settings;  ///< what and value, for the report
};

/// Points that the final pose of a pattern rests on.
[[nodiscard]] std::size_t pose_points(const Pattern& pattern);

/// The tables as plain text, a few lines each.
[[nodiscard]] std::string qualify_text(const QualifyResults& results);

/// Writes report.html, the charts as PNG, and measured.csv (every frame of the last row) into the folder, which is
/// made where there is none. Throws IoError.
void write_qualify_report(const QualifyResults& results, const std::string& folder);

}  // namespace vsfind
