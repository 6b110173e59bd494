#pragma once
/// @file
/// Candidates of the exhaustive search followed down the pyramid, from its top to half the full resolution.

#include <chrono>
#include <vector>

#include "finder/fit.h"
#include "finder/prepared_pattern.h"
#include "finder/pyramid.h"

namespace vsfind {

/// The picture as one pattern sees it.
struct SearchScene {
  ImageView image;             ///< what full resolution is read from: the picture, or its edges
  Pyramid* pyramid = nullptr;  ///< smooths its levels when they are asked for
  const Mapping* mapping = nullptr;
};

/// Where the pattern may lie.
struct Candidate {
  Pose pose;
  double score = 0.0;   ///< correlation at the top, then FitResult::explained
  float coarse = 0.0F;  ///< its score in the exhaustive search
  GreyLine line;        ///< of the picture, where the fit was so good that it need not be looked for again
};

/// Explained part of the pattern from which on a candidate is clearly better than a chance likeness.
inline constexpr double sure_part = 0.8;

/// Keeps its scratch memory between pictures.
class Descent {
 public:
  /// Leaves of `candidates` those worth a fit at full resolution, best first. `known`: how much of the pattern the best
  /// match so far explains. Past `deadline` it stops and sets `timed_out`.
  void run(const PreparedPattern& prepared, const SearchScene& scene, const SearchOptions& options, double known,
           std::chrono::steady_clock::time_point deadline, std::vector<Candidate>& candidates, bool& timed_out);

 private:
  struct Stage;

  /// One candidate on one level. `best`: the best score so far there. Returns the part of the points in the picture.
  double follow(const Stage& stage, double best, Candidate& candidate);
  /// Of those kept the ones that are worth the next level.
  void thin_out(const Stage& stage, double min_score, double known, std::vector<Candidate>& candidates);
  void climb(const PreparedPattern& prepared, const SearchScene& scene, Candidate& candidate);
  /// Of edges, as they were read last: their correlation, less where points are outside.
  [[nodiscard]] double likeness(const PointArrays& points, Polarity polarity) const;

  PoseFit fit_;
  std::vector<Candidate> kept_;  ///< of one level
};

}  // namespace vsfind
