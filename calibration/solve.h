#pragma once
/// @file
/// A calibration from board views or from point pairs.

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/image_view.h"
#include "calibration/board.h"
#include "calibration/calibration.h"

namespace vsfind {

struct SolveOptions {
  std::string unit = "mm";
  int image_width = 0;  ///< of the whole frame
  int image_height = 0;
  Field made_from = Field::frame;
  double pixel_aspect = 1.0;   ///< for the record where no lens tells it
  std::optional<Lens> lens;    ///< known already: only the plane is solved
  bool solve_lens = true;      ///< from several views, where no lens is known; else the plane alone
  int distortion = 5;          ///< coefficients solved: 0, 2 (k1 k2), 4 (… p1 p2), 5 (… k3) or 8 (… k4 k5 k6)
  std::size_t plane_view = 0;  ///< index of the view whose board is the plane
};

/// Standard deviations of a solved lens, from the residuals and how well the views determine it.
struct LensUncertainty {
  double fx = 0.0;
  double fy = 0.0;
  double cx = 0.0;
  double cy = 0.0;
  std::vector<double> coefficients;
};

struct Solution {
  Calibration calibration;
  std::vector<std::optional<PlanePose>> poses;  ///< of every view's board, with a lens
  std::optional<LensUncertainty> uncertainty;   ///< where the lens was solved
  double covered = 0.0;                         ///< part of the image that the views' points cover, 0 … 1
  std::vector<std::string> warnings;            ///< plain sentences
};

/// Lens and plane from board views. One view without a known lens gives the plane alone (a homography). Circles are
/// corrected for the shift that perspective gives a circle's centre of area. Throws UsageError, naming the reason,
/// where the views cannot determine what is asked for.
[[nodiscard]] Solution solve_views(const std::vector<BoardView>& views, const SolveOptions& options);

/// Whether and why the solved lens deserves suspicion; refusals throw UsageError. Part of solve_views(), apart for
/// tests.
void judge_lens(const std::vector<BoardView>& views, const SolveOptions& options, Solution& solution);

/// The residuals of points under a mapping of whole frames.
[[nodiscard]] ViewResidual residual_of(const Mapping& mapping, const BoardView& view);

}  // namespace vsfind
