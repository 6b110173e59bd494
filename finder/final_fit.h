#pragma once
/// @file
/// The sub-pixel pose of one candidate at full resolution, its score, and what may be expected of its accuracy.

#include "finder/descent.h"
#include "finder/field_fit.h"
#include "finder/fit.h"
#include "finder/prepared_pattern.h"

namespace vsfind {

/// Keeps its scratch memory between pictures.
class FinalFit {
 public:
  /// Fills `match` and the candidate's score. False where the candidate is nothing, or cannot score `min_score`.
  bool run(const PreparedPattern& prepared, const SearchScene& scene, double min_score, Candidate& candidate,
           Match& match);

 private:
  /// The pose by the few best points, with what helps where the picture is shaded or much is hidden.
  FitResult fit_best_points(const PreparedPattern& prepared, const Projection& projection, const Reader& reader,
                            const FitOptions& options, Pose& pose);
  /// Score, polarity and how the pattern is seen at the match's pose.
  FitResult look(const PreparedPattern& prepared, const Projection& projection, const Reader& reader, Match& match);

  PoseFit fit_;
  FieldFit field_fit_;
};

}  // namespace vsfind
