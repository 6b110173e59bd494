#pragma once
/// @file
/// The exhaustive search at the top of the pyramid: every position, every hypothesis, a few dozen points each.

#include <cstdint>
#include <vector>

#include "finder/coarse_grid.h"
#include "finder/pattern.h"
#include "finder/points.h"
#include "finder/thread_pool.h"

namespace vsfind {

/// The points of the exhaustive search, values quantized so that all sums are exact integers.
struct CoarsePoints {
  std::vector<double> x;  ///< pattern pixels from the origin; an even number of points, at most kernels::max_points
  std::vector<double> y;
  std::vector<std::int16_t> weight;  ///< −127 … 127
  std::vector<std::int16_t> weight_squared;
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

/// What is looked for, and where.
struct CoarseTask {
  const CoarsePoints* points = nullptr;
  const std::vector<Hypothesis>* hypotheses = nullptr;
  Projection projection;  ///< level: the one searched, smoothed
  Polarity polarity = Polarity::same;
  float threshold = 0.5F;       ///< candidates below are left out
  float min_inside = 0.6F;      ///< part of the points that must lie in the picture
  std::size_t most = 64;        ///< candidates at the most
  const Roi* region = nullptr;  ///< frame pixels for the origin
};

/// Keeps its memory between pictures.
class CoarseSearch {
 public:
  /// Local maxima over position of the best hypothesis there, best first. Independent of the number of threads.
  void run(const CoarseTask& task, ThreadPool& threads, std::vector<CoarseCandidate>& out);

 private:
  void prepare_plane(const Level& level, int margin);

  std::vector<std::uint8_t> plane_;  // the level with a margin of 128 all around
  std::vector<std::uint8_t> mask_;   // 129 where the plane has a picture, 128 around it
  int width_ = 0;
  int height_ = 0;
  int margin_ = 0;
  std::ptrdiff_t stride_ = 0;
  std::vector<float> best_;
  std::vector<std::uint16_t> which_;
};

}  // namespace vsfind
