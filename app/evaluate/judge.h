#pragma once
/// @file
/// What was found in a picture compared with what ought to be found.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/image_view.h"
#include "app/evaluate/truth_file.h"
#include "finder/search.h"

namespace vsfind {

/// How far from the truth a match may lie and still be right.
struct Tolerance {
  double position = 2.0;   ///< in the unit of the truth: px, or the calibration's
  double angle_deg = 2.0;  ///< where the truth has an angle
};

enum class Verdict {
  right,
  missed,       ///< nothing within the tolerance
  false_alarm,  ///< a match where nothing ought to be
};
[[nodiscard]] constexpr const char* name(Verdict verdict) {
  return verdict == Verdict::right ? "right" : verdict == Verdict::missed ? "missed" : "false_alarm";
}

/// One expected instance, or one match that nobody expected.
struct Judgement {
  Verdict verdict = Verdict::right;
  std::uint64_t frame = 0;
  Field field = Field::frame;
  std::string model;
  std::optional<TruthRow> truth;
  std::optional<Match> match;
  /// Found minus true, where right.
  double error_x = 0.0;
  double error_y = 0.0;
  std::optional<double> error_angle_deg;
  std::optional<double> error_scale_x;
  std::optional<double> error_scale_y;
};

/// Pairs matches and truth, the nearest first, each once. `in_frame_pixels`: the truth's coordinates are frame pixels,
/// else the plane's. Rows of the truth that are not `present` expect nothing.
[[nodiscard]] std::vector<Judgement> judge_picture(const std::vector<Match>& matches,
                                                   const std::vector<TruthRow>& truth, bool in_frame_pixels,
                                                   const Tolerance& tolerance);

}  // namespace vsfind
