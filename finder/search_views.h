#pragma once
/// @file
/// What the candidates for the points of the exhaustive search read in every situation that the choice among them must
/// reckon with: the pattern itself as the coarse grid meets it, its own copies and whatever else looks like it in the
/// training scene, and what looks like it in the scenes that it must be told from.

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <vector>

#include "finder/coarse_grid.h"
#include "finder/coarse_search.h"
#include "finder/training_scene.h"

namespace vsfind {

/// A further scene that must not be taken for the pattern: its smoothed level of the same resolution, whose memory must
/// outlive it, and its mapping.
struct AgainstLevel {
  Level level;
  Mapping mapping;
};

/// Values that all candidates read, grey levels 0 … 255: views[m][k] is what candidate k reads in situation m.
using Views = std::vector<std::vector<float>>;

/// Sums over some of the candidates in one situation.
struct Sums {
  float i = 0.0F;   ///< of the values read
  float ii = 0.0F;  ///< of their squares
  float it = 0.0F;  ///< of their products with the pattern's values
};

/// Normalized correlation, −1 … 1, of `n` candidates whose pattern values have the sum `t` and the sum of squares `tt`;
/// 0 where what is read or the pattern has a standard deviation below one grey level. Here for the innermost loop.
[[nodiscard]] inline float score_of(float n, const Sums& seen, float t, float tt) {
  const float vi = n * seen.ii - seen.i * seen.i;
  const float vt = n * tt - t * t;
  if (vi < n * n || vt < n * n) return 0.0F;
  return (n * seen.it - seen.i * t) / std::sqrt(vi * vt);
}

/// The candidates of one level and their views. Views are there once collected.
class SearchViews {
 public:
  /// Lays the candidates over the pattern, a level pixel apart, thinned out to about 700 where there are more, and
  /// reads the pattern at them; those that its picture does not show are left out. The scene and `against` must outlive
  /// it.
  SearchViews(TrainingScene& scene, int level, const CoarseGrid& grid, const std::vector<AgainstLevel>& against);

  /// The pattern itself as the coarse search meets it: anywhere within a cell of the grid, offsets rounded to whole
  /// pixels, and the level as if the camera had stood a part of a level pixel off.
  void collect_genuine();
  /// The pattern's own copies, shifted and turned by more than a cell.
  void collect_own_copies();
  /// What looks like the pattern in the scenes to tell it from, to points from all over it: before the first choice.
  void collect_strangers();
  /// What the candidates of these indices mistake for the pattern, in the training scene and the scenes to tell it
  /// from.
  void collect_impostors(const std::vector<std::size_t>& chosen);

  [[nodiscard]] std::size_t size() const { return candidates_.size(); }
  /// By candidate: pattern pixels from the origin, and the pattern's own value there, 0 … 255.
  [[nodiscard]] const std::vector<Eigen::Vector2d>& candidates() const { return candidates_; }
  [[nodiscard]] const std::vector<float>& values() const { return values_; }
  [[nodiscard]] PatternPoint point(std::size_t k) const;

  [[nodiscard]] const Views& genuine() const { return genuine_; }
  [[nodiscard]] const Views& impostors() const { return impostors_; }  ///< of the training scene
  [[nodiscard]] const Views& strangers() const { return strangers_; }  ///< of the scenes to tell the pattern from
  /// By candidate: 1 where it tells the pattern from the likest of the strangers; there after collect_strangers().
  [[nodiscard]] const std::vector<char>& telling() const { return telling_; }
  [[nodiscard]] std::size_t telling_count() const { return telling_count_; }

 private:
  void thin_out();
  void drop_unread();
  /// What the candidates would read of a level picture at a pose; candidates outside read NaN.
  [[nodiscard]] std::vector<float> read(const Level& level, const Mapping& mapping, const Pose& pose) const;
  /// Outside the picture nobody knows what there is: the pattern's own mean is neutral.
  [[nodiscard]] std::vector<float> whole(std::vector<float> view) const;
  /// Of all candidates together.
  [[nodiscard]] float whole_score(const std::vector<float>& view) const;
  void add_impostor(const Level& level, const Mapping& mapping, const Pose& pose, Views& views) const;
  /// What the exhaustive search would find with the candidates of these indices.
  [[nodiscard]] std::vector<CoarseCandidate> look_for(const std::vector<std::size_t>& chosen, const Level& level,
                                                      const Mapping& mapping) const;
  /// The view of another scene that all candidates together take for the pattern most: uphill from the best few.
  [[nodiscard]] std::vector<float> likest(const AgainstLevel& other, const std::vector<CoarseCandidate>& found) const;

  const TrainingScene& scene_;
  const std::vector<AgainstLevel>& against_;
  CoarseGrid grid_;
  int level_index_;
  Level level_;  ///< smoothed
  double step_;  ///< of a level pixel, pattern pixels
  std::vector<Eigen::Vector2d> candidates_;
  std::vector<float> values_;
  Views genuine_;
  Views impostors_;
  Views strangers_;
  std::vector<char> telling_;
  std::size_t telling_count_ = 0;
};

}  // namespace vsfind
