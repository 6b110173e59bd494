#pragma once
/// @file
/// Finding trained patterns in a picture.

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "acquisition/image_view.h"
#include "calibration/mapping.h"
#include "finder/pattern.h"

namespace vsfind {

/// What is asked of a search. Checked once, by Finder's constructor.
struct SearchOptions {
  double min_score = 0.65;  ///< 0 … 1: weaker ones are not reported
  /// 0 … 1, coarse acceptance: candidates of the exhaustive search that correlate less are not followed. Else half of
  /// min_score.
  std::optional<double> coarse_score;
  int max_instances = 1;           ///< 0: all, most_of_all at the most
  double max_overlap = 0.5;        ///< 0 … 1: part of the smaller outline that two instances may share
  std::optional<Roi> region;       ///< frame pixels in which the origin is looked for; else the whole picture
  std::optional<Range> angle_deg;  ///< narrower than trained
  std::optional<Range> scale_x;
  std::optional<Range> scale_y;
  double timeout_ms = 0.0;  ///< 0: none; else the best so far is returned, marked
  int threads = 1;          ///< 1 … 64; the results do not depend on it

  static constexpr int most_of_all = 200;
  [[nodiscard]] std::size_t wanted() const {
    return static_cast<std::size_t>(max_instances == 0 ? most_of_all : max_instances);
  }
};

/// One instance found.
struct Match {
  Pose pose;
  double score = 0.0;                        ///< normalized correlation, 0 … 1
  Eigen::Vector2d frame_position{0.0, 0.0};  ///< the origin in pixels of the whole frame
  double sigma_x = 0.0;                      ///< predicted standard deviations, plane units
  double sigma_y = 0.0;
  double sigma_angle_deg = 0.0;        ///< 0 where the angle is not searched
  double visible = 1.0;                ///< part of the pattern inside the image and not hidden
  Polarity polarity = Polarity::same;  ///< same or reversed
};

/// What one search found of one pattern, best first.
struct PatternMatches {
  std::vector<Match> matches;
  bool timed_out = false;  ///< timeout_ms ran out: candidates are left that nobody has looked at
};

/// Searches pictures for one or several patterns; keeps its scratch memory between calls. Not for use by two threads
/// at once.
class Finder {
 public:
  /// Throws UsageError where an option is out of range or wider than the patterns were trained for.
  Finder(std::vector<std::shared_ptr<const Pattern>> patterns, const SearchOptions& options);
  ~Finder();
  Finder(Finder&&) noexcept;
  Finder& operator=(Finder&&) noexcept;

  [[nodiscard]] const std::vector<std::shared_ptr<const Pattern>>& patterns() const;

  /// One entry per pattern, in their order; valid until the next call. `mapping` takes pixels of `image` to the plane.
  /// Any image is searched without an exception: an empty one, or one too small, gives no match.
  const std::vector<PatternMatches>& find(const ImageView& image, const Mapping& mapping);

  /// Wall time of the last find(), pyramid to pose.
  [[nodiscard]] double search_ms() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vsfind
