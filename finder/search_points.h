#pragma once
/// @file
/// The points of the exhaustive search: few, and such that together they tell the pattern from everything else while
/// the steps of the coarse grid leave them alone.

#include <vector>

#include "finder/coarse_grid.h"
#include "finder/search_views.h"
#include "finder/training_scene.h"

namespace vsfind {

/// One level's proposal.
struct SearchPoints {
  int level = 0;
  CoarseGrid grid;
  std::vector<PatternPoint> points;
  double worst_genuine = 0.0;  ///< lowest score of the pattern itself over the poses of a cell of the coarse grid
  double best_impostor = 0.0;  ///< highest score of anything else
  [[nodiscard]] double margin() const { return worst_genuine - best_impostor; }
};

/// Steps of the coarse grid at a level in angle and scale: half a step moves the points by about half a level pixel
/// (r.m.s.), times `widening`.
[[nodiscard]] CoarseGrid coarse_grid(const TrainingScene& scene, int level, const TrainOptions& options,
                                     double widening = 1.0);

/// Greedy choice at one level (after Krattenthaler, Mayer & Zeiller 1994, with the level's own impostors). `against`:
/// further scenes, as smoothed levels of the same resolution, with their mappings. No points where the level has too
/// few.
[[nodiscard]] SearchPoints choose_search_points(TrainingScene& scene, int level, const TrainOptions& options,
                                                const std::vector<AgainstLevel>& against, double widening = 1.0);

}  // namespace vsfind
