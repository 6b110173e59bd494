#pragma once
/// @file
/// The report of a run: score, position and angle over time, histograms of the times, a gallery of failures.

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "app/frame_searcher.h"
#include "app/source_mapping.h"
#include "app/summary.h"

namespace vsfind {

/// Collects what the report shows in bounded memory however long the run: of a very long one, every second, fourth, …
/// frame is charted; counts are of all. Keeps the pictures of the first failures and of the weakest matches.
class RunReport {
 public:
  /// Makes the folder where there is none. Throws IoError.
  RunReport(std::string folder, std::vector<std::shared_ptr<const Pattern>> patterns);

  /// The pictures of the result must have been kept for the gallery to show them.
  void add(const FrameResult& result, const SourceMapping& mapping, double latency_ms);

  /// Writes report.html and the charts as PNG. Throws IoError.
  void write(const Summary& summary) const;

 private:
  /// One pattern in one picture: the best instance.
  struct Sample {
    double frame = 0.0;  ///< of the source's counter; the second field half a frame later
    double score = 0.0;  ///< NaN, like the pose, where it was not found
    double x = 0.0;
    double y = 0.0;
    double angle_deg = 0.0;
    double search_ms = 0.0;
    double latency_ms = 0.0;
  };
  struct Shot {
    std::string caption;
    double score = 0.0;
    cv::Mat picture;
  };

  void keep_shot(const FrameResult& result, const PictureResult& picture, const SourceMapping& mapping);
  void thin_out();

  std::string folder_;
  std::vector<std::shared_ptr<const Pattern>> patterns_;
  std::vector<std::vector<Sample>> samples_;  ///< of each pattern
  std::vector<Shot> failures_;
  std::vector<Shot> weakest_;  ///< the lowest score first
  std::string source_;
  std::string unit_ = "px";
  std::uint64_t stride_ = 1;
  std::uint64_t frames_ = 0;
  std::uint64_t failed_pictures_ = 0;
  std::uint64_t gaps_ = 0;  ///< frames that the source's counter jumped over
  std::uint64_t last_frame_ = 0;
  std::vector<std::uint64_t> bad_frames_;  ///< the first ones
};

}  // namespace vsfind
