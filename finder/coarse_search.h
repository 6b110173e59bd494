#pragma once
/// @file
/// The exhaustive search at the top of the pyramid: every position, every hypothesis, a few dozen points each.
///
/// Two passes. The first takes at every position the hypothesis whose correlation sum is highest, in 8-bit integers and
/// without regard to the picture's contrast: the points' weights sum to zero, so brightness cancels, and contrast is
/// much the same for all hypotheses of one place. The second normalizes exactly, at the local maxima that are left.

#include <Eigen/Core>
#include <chrono>
#include <cstdint>
#include <vector>

#include "finder/coarse_grid.h"
#include "finder/pattern.h"
#include "finder/points.h"
#include "finder/thread_pool.h"

namespace vsfind {

/// Most points of one pattern: all sums fit 32 bits then.
inline constexpr int most_coarse_points = 128;
/// Most hypotheses that are told apart.
inline constexpr std::size_t most_hypotheses = 65535;

/// The points of the exhaustive search in their order of choice, values quantized so that all sums are exact integers.
struct CoarsePoints {
  std::vector<double> x;  ///< pattern pixels from the origin; an even number of points
  std::vector<double> y;
  std::vector<std::int16_t> weight;  ///< −127 … 127; padded with zeros for kernels::sums_inside()
  std::vector<std::int8_t> first;    ///< of the first pass: the first points' weights, summing to zero
  double anchor_x = 0.0;  ///< middle of the points: positions are scanned for it, so that a far origin costs nothing
  double anchor_y = 0.0;

  CoarsePoints() = default;
  explicit CoarsePoints(const std::vector<PatternPoint>& points);
  [[nodiscard]] int size() const { return static_cast<int>(x.size()); }
};

struct CoarseCandidate {
  Pose pose;
  float score = 0.0F;  ///< normalized correlation of the points, signed
};

/// Columns of a row, ends included.
struct ColumnRange {
  int left = 0;
  int right = -1;
};

/// What is looked for, and where.
struct CoarseTask {
  const CoarsePoints* points = nullptr;
  const std::vector<Hypothesis>* hypotheses = nullptr;  ///< at most most_hypotheses
  Projection projection;                                ///< level: the one searched, smoothed
  Polarity polarity = Polarity::same;
  float threshold = 0.5F;       ///< candidates below are left out
  float min_inside = 0.5F;      ///< part of the points that must lie in the picture
  std::size_t most = 64;        ///< candidates at the most
  std::size_t places = 1;       ///< wanted: so many of the best, three at least, are tried with every hypothesis
  const Roi* region = nullptr;  ///< frame pixels for the origin
  /// Of each row of the level what the picture shows, for the middle of the pattern; not given: all of it.
  const std::vector<ColumnRange>* shown = nullptr;
  /// When to give up, within a row of the level; max(): never.
  std::chrono::steady_clock::time_point deadline = std::chrono::steady_clock::time_point::max();
};

/// Keeps its memory between pictures.
class CoarseSearch {
 public:
  /// Local maxima over position of the best hypothesis there, best first. Independent of the number of threads. False,
  /// and `out` empty, where the deadline has passed before every position was tried.
  bool run(const CoarseTask& task, ThreadPool& threads, std::vector<CoarseCandidate>& out);

 private:
  /// Where the points of one hypothesis fall, relative to the anchor.
  struct Copy {
    std::vector<std::int16_t> du, dv;     ///< whole level pixels
    std::vector<std::ptrdiff_t> offsets;  ///< the same in the plane
    int left = 0;
    int right = 0;
    int top = 0;
    int bottom = 0;
    Eigen::Vector2d origin{0.0, 0.0};  ///< of the pattern relative to the anchor, level pixels
    /// What makes up for points outside the picture (kernels::best_dots()), in rows like those of the scores: of each
    /// of the upper rows, in which the pattern is cut off above, of all in which it is not, of each of the lower ones.
    std::vector<std::int16_t> factors;
    int upper_rows = 0;
    int lower_rows = 0;
  };
  /// Positions of the anchor that are tried, level pixels, ends included.
  struct Window {
    int left = 0;
    int right = 0;
    int top = 0;
    int bottom = 0;
  };
  struct Peak {
    float score = 0.0F;
    int u = 0;
    int v = 0;
    std::size_t hypothesis = 0;
  };

  [[nodiscard]] static bool better(const Peak& a, const Peak& b);
  void prepare_copies(const CoarseTask& task);
  void prepare_factors(const CoarsePoints& points, float min_inside, Copy& copy) const;
  [[nodiscard]] const std::int16_t* factors_of(const Copy& copy, int v) const;
  void prepare_plane(const Level& level);
  [[nodiscard]] std::uint8_t* plane_row(int v) {
    return plane_.data() + static_cast<std::ptrdiff_t>(v + margin_) * stride_ + margin_;
  }
  [[nodiscard]] const std::uint8_t* plane_row(int v) const {
    return plane_.data() + static_cast<std::ptrdiff_t>(v + margin_) * stride_ + margin_;
  }
  [[nodiscard]] std::int16_t* score_row(int v) {
    return scores_.data() + 1 + static_cast<std::ptrdiff_t>(v + 1) * row_;
  }
  [[nodiscard]] Window window_of(const CoarseTask& task, const Copy& copy) const;
  /// False where the deadline has passed before the last row.
  bool first_pass(const CoarseTask& task, int first_row, int end_row);
  void second_pass(const CoarseTask& task);
  /// Looks at the best places again with every hypothesis: what is nearly symmetric fits in several ways, and the first
  /// pass, which does not normalize, may have taken the wrong one.
  void other_ways(const CoarseTask& task);
  [[nodiscard]] float correlation(const CoarseTask& task, const Copy& copy, int u, int v) const;

  std::vector<Copy> copies_;
  std::vector<Window> windows_;
  // What the copies were made for.
  const CoarsePoints* copied_points_ = nullptr;
  const std::vector<Hypothesis>* copied_hypotheses_ = nullptr;
  Eigen::Matrix2d copied_slope_ = Eigen::Matrix2d::Zero();

  std::vector<std::uint8_t> plane_;  // the level's contrast stretched to 7 bits, with a margin
  int width_ = 0;
  int height_ = 0;
  int margin_ = 0;
  std::ptrdiff_t stride_ = 0;
  std::vector<int> left_, right_, edge_, running_;  // scratch of prepare_plane()
  int row_ = 0;                                     // entries of a row of the two arrays below
  std::vector<std::int16_t> scores_;    // of the best hypothesis at each position, rows from −1 to height_
  std::vector<std::uint16_t> which_;    // the best hypothesis
  std::vector<std::uint16_t> columns_;  // scratch of second_pass()
  std::vector<Peak> peaks_;
  std::vector<Peak> ways_, more_;   // scratch of other_ways()
  std::vector<std::uint8_t> done_;  // which workers came to the end of their rows
};

}  // namespace vsfind
