#pragma once
/// @file
/// The pattern's points read from the training scene, and those of each use but the exhaustive search's chosen.

#include <vector>

#include "finder/fit.h"
#include "finder/pattern.h"
#include "finder/train.h"
#include "finder/training_scene.h"

namespace vsfind {

/// What the options let move.
[[nodiscard]] Freedom freedom_of(const TrainOptions& options);

/// Every pixel of the pattern read through the Gaussian, with derivatives from its neighbours: rough ones, for
/// choosing.
[[nodiscard]] std::vector<PatternPoint> rough_points(TrainingScene& scene);

/// The points of the sub-pixel pose chosen from all of those: inner ones, then those of the outline.
[[nodiscard]] std::vector<PointSet> refine_points(TrainingScene& scene, const TrainOptions& options,
                                                  const std::vector<PatternPoint>& all);

/// Evenly spread over the whole pattern, flat parts too: what the score is measured on.
[[nodiscard]] PointSet verify_points(const TrainingScene& scene);

/// Those that follow candidates down at a level.
[[nodiscard]] PointSet follow_points(TrainingScene& scene, const TrainOptions& options, int level);

}  // namespace vsfind
