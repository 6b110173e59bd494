#pragma once
/// @file
/// A stage's analysis as charts, of the kind that the literature shows.

#include <string>
#include <vector>

#include "app/qualify/stage_analysis.h"
#include "app/report/chart.h"

namespace vsfind {

struct NamedChart {
  std::string file;     ///< name of its PNG
  std::string caption;  ///< a sentence
  Chart chart;
};

/// What there is to be seen of a run: nonlinearity of pattern and fiducials, the pattern relative to the fiducials.
[[nodiscard]] std::vector<NamedChart> stage_charts(const StageRun& run, const StageAnalysis& analysis);

/// The first picture with the pattern's outline and the fiducials drawn in.
[[nodiscard]] cv::Mat stage_picture(const StageRun& run, const SourceMapping& mapping);

}  // namespace vsfind
