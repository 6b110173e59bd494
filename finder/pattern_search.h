#pragma once
/// @file
/// One pattern followed from the top of a pyramid down to its sub-pixel pose.

#include <chrono>
#include <vector>

#include "finder/coarse_search.h"
#include "finder/field_fit.h"
#include "finder/fit.h"
#include "finder/prepared_pattern.h"
#include "finder/rectified_level.h"

namespace vsfind {

/// The picture as one pattern sees it.
struct SearchScene {
  ImageView image;             ///< what full resolution is read from: the picture, or its edges
  Pyramid* pyramid = nullptr;  ///< smooths its levels when they are asked for
  const Mapping* mapping = nullptr;
};

/// Keeps its scratch memory between pictures.
class PatternSearch {
 public:
  /// Fills `out`, best first. `deadline`: when to stop with the best so far.
  void run(const PreparedPattern& prepared, const SearchScene& scene, const SearchOptions& options, ThreadPool& threads,
           std::chrono::steady_clock::time_point deadline, PatternMatches& out);

 private:
  struct Candidate {
    Pose pose;
    double score = 0.0;   ///< correlation at the top, then FitResult::explained
    float coarse = 0.0F;  ///< its score in the exhaustive search
    GreyLine line;        ///< of the picture, where the fit was so good that it need not be looked for again
  };
  struct Found {
    double explained = 0.0;
    Match match;
    float coarse = 0.0F;  ///< as of the candidate
    bool convincing = false;
  };

  void climb(const PreparedPattern& prepared, const SearchScene& scene, Candidate& candidate);
  /// Of edges, as they were read last: their correlation, less where points are outside.
  [[nodiscard]] double likeness(const PointArrays& points, Polarity polarity) const;
  void follow_down(const PreparedPattern& prepared, const SearchScene& scene, const SearchOptions& options,
                   std::chrono::steady_clock::time_point deadline, bool& timed_out);
  /// Score, polarity and how the pattern is seen at the match's pose.
  FitResult look(const PreparedPattern& prepared, const Projection& projection, const Reader& reader, Match& match);
  bool finish(const PreparedPattern& prepared, const SearchScene& scene, double min_score, Candidate& candidate,
              Match& match);

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
  std::vector<Candidate> kept_;  // scratch of follow_down()
  PoseFit fit_;
  FieldFit field_fit_;
};

}  // namespace vsfind
