#pragma once
/// @file
/// The search for one pattern: exhaustive at the top of the pyramid, then the best candidates first, down to their
/// sub-pixel poses, until the matter is settled.

#include <chrono>
#include <vector>

#include "finder/coarse_search.h"
#include "finder/descent.h"
#include "finder/final_fit.h"
#include "finder/prepared_pattern.h"
#include "finder/rectified_level.h"

namespace vsfind {

/// Keeps its scratch memory between pictures.
class PatternSearch {
 public:
  /// Fills `out`, best first. `deadline`: when to stop with the best so far.
  void run(const PreparedPattern& prepared, const SearchScene& scene, const SearchOptions& options, ThreadPool& threads,
           std::chrono::steady_clock::time_point deadline, PatternMatches& out);

 private:
  struct Found {
    double explained = 0.0;
    Match match;
    float coarse = 0.0F;  ///< as of the candidate
    bool convincing = false;
  };

  /// Whether a match that is likely the right one did much better in the exhaustive search.
  [[nodiscard]] bool led_clearly(const CoarseCandidate& peak) const;
  /// Whether a convincing match lies there already.
  [[nodiscard]] bool near_settled(const PreparedPattern& prepared, const Pose& pose) const;
  void choose_matches(const PreparedPattern& prepared, const SearchOptions& options, std::size_t wanted,
                      PatternMatches& out);

  RectifiedLevel rectified_;
  CoarseSearch coarse_;
  std::vector<CoarseCandidate> peaks_;
  std::vector<Candidate> candidates_;
  std::vector<Found> found_;
  Descent descent_;
  FinalFit final_fit_;
};

}  // namespace vsfind
