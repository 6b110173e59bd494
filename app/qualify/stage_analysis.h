#pragma once
/// @file
/// The experiment's second half: what the positions found along a stage's travel say.

#include <optional>
#include <string>
#include <vector>

#include "app/qualify/stage_run.h"
#include "app/report/spread.h"

namespace vsfind {

enum class StageKind { linear, rotary };
[[nodiscard]] constexpr const char* name(StageKind kind) { return kind == StageKind::linear ? "linear" : "rotary"; }

/// One value per frame of the run; NaN where it could not be measured.
struct Deviations {
  std::vector<double> values;
  Spread spread;
};

struct StageAnalysis {
  StageKind kind = StageKind::linear;
  std::size_t frames = 0;
  std::size_t found = 0;           ///< frames with the pattern
  std::size_t with_fiducials = 0;  ///< frames with pattern and fiducials
  double travel = 0.0;             ///< from the first place found to the last, units or degrees
  double steps = 0.0;              ///< of the stage between these
  double direction_deg = 0.0;      ///< of a linear stage, from +x toward +y

  /// Linear stage: distance from the straight line fitted to the travel, and along it from equal steps. Units.
  Deviations pattern_across, pattern_along, fiducials_across, fiducials_along;
  /// Rotary stage: from equal steps of the angle, degrees.
  Deviations pattern_turn, fiducials_turn;
  /// The pattern relative to the fiducials, their constant part taken off: position in the fiducials' own (turned)
  /// axes, units, and angle, degrees.
  Deviations relative_x, relative_y, relative_angle;
  double relative_max = 0.0;  ///< largest distance
  /// Relative to the truth, where it is known, mean kept.
  Deviations truth_x, truth_y, truth_angle;

  double fiducial_sigma = 0.0;  ///< predicted by the line fits, per axis, units
  double fiducial_sigma_angle_deg = 0.0;
  double predicted_x = 0.0;  ///< the finder's own sigma, mean of all frames
  double predicted_y = 0.0;
  double predicted_angle_deg = 0.0;
  double median_ms = 0.0;
  double max_ms = 0.0;
};

/// Throws UsageError where the pattern was found in fewer than three frames.
[[nodiscard]] StageAnalysis analyse_stage(const StageRun& run, StageKind kind);

/// One S.D. for both axes: the root of the mean of their variances.
[[nodiscard]] double per_axis(const Deviations& x, const Deviations& y);

}  // namespace vsfind
