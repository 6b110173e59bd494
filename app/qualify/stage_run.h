#pragma once
/// @file
/// The experiment's first half: pattern and fiducials found in every frame.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/source.h"
#include "app/frame_searcher.h"
#include "app/qualify/fiducials.h"
#include "app/qualify/pose_bound.h"
#include "app/source_mapping.h"
#include "finder/search.h"

namespace vsfind {

/// Which squares serve as fiducials.
struct FiducialChoice {
  bool wanted = true;
  std::vector<Roi> regions;  ///< one square in each in the first frame; empty: the four around the pattern
};

/// What was measured in one good frame.
struct StageFrame {
  std::uint64_t frame = 0;
  double step = 0.0;  ///< of the stage, from the first frame's 0; frames that were bad or lost count
  std::optional<Match> match;
  std::optional<FiducialPose> fiducials;
  std::optional<Pose> truth;  ///< where it is known
  double search_ms = 0.0;
  double noise = 0.0;  ///< grey levels of 255
};

struct StageRun {
  std::shared_ptr<const Pattern> pattern;
  std::string source;
  std::string unit;
  int width = 0;
  int height = 0;
  Field field = Field::frame;
  std::vector<StageFrame> frames;
  std::size_t bad_frames = 0;
  double noise = 0.0;  ///< mean of all frames
  PoseBound bound;     ///< with the angle where the pattern was searched over angles
  bool angle_searched = false;
  std::vector<RoughSquare> squares;  ///< fiducials in the first frame that has them, pixels of the picture
  GreyPicture picture;               ///< of that frame, or of the first one
  std::optional<Match> picture_match;
};

struct StageRequest {
  std::shared_ptr<const Pattern> pattern;
  SearchOptions search;
  SourceMapping mapping;
  Field field = Field::frame;  ///< which lines of whole frames are looked at
  FiducialChoice fiducials;
  std::vector<Pose> truth;  ///< of every frame, where it is known
};

/// Looks for one pattern and the fiducials in frame after frame.
class StageRunner {
 public:
  StageRunner(const SourceInfo& source, StageRequest request);

  /// Throws UsageError where a region holds no square, naming it, or the frame has not the calibration's size.
  void add(const Frame& frame);

  /// What was measured; to be asked once, at the end.
  [[nodiscard]] StageRun finish();

 private:
  StageRequest request_;
  Finder finder_;
  StageRun run_;
  std::optional<FiducialTracker> tracker_;
  PoseBoundEstimator bound_;
  double noise_sum_ = 0.0;
  double step_ = 0.0;
  std::uint64_t last_ = 0;  ///< number of the frame before
  bool any_ = false;
};

/// Runs once through the source, or through so many good frames of it, with a runner for each request. Throws what the
/// source and the runners throw.
[[nodiscard]] std::vector<StageRun> run_stage(FrameSource& source, const std::vector<StageRequest>& requests,
                                              std::size_t most_frames = 0);

}  // namespace vsfind
