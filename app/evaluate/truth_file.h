#pragma once
/// @file
/// Known or hand-marked poses: what a finder must answer, frame by frame.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/image_view.h"
#include "finder/pose.h"

namespace vsfind {

/// One line of the list.
struct TruthRow {
  std::uint64_t frame = 0;
  std::optional<Field> field;  ///< nothing: the frame, and each of its fields, alike
  std::string model;           ///< "": every model
  bool present = false;        ///< else the line says that nothing is there
  /// The position, in plane coordinates or in frame pixels as the columns say.
  double x = 0.0;
  double y = 0.0;
  std::optional<double> angle_deg;
  std::optional<double> scale_x;
  std::optional<double> scale_y;
  int line = 0;  ///< in the file, from 1
};

struct TruthFile {
  bool in_frame_pixels = false;  ///< the columns are image_x, image_y
  std::vector<TruthRow> rows;
};

/// Reads CSV with a header. `frame` and either `x`, `y` (calibrated coordinates) or `image_x`, `image_y` (frame pixels)
/// are needed; where all four stand, x and y are taken. Optional: `field` (frame, top, bottom), `model`, `angle_deg`,
/// `scale_x`, `scale_y`, `status`. A line without position, or of a status other than `found`, says that nothing is
/// there. All other columns are passed over, so that a file of results is itself a list of truth. At most 64 MB. Throws
/// UsageError: `file:line: column: what is wrong (allowed: …)`.
[[nodiscard]] TruthFile parse_truth(const std::string& text, const std::string& file);
/// Throws IoError where it cannot be read.
[[nodiscard]] TruthFile load_truth(const std::string& path);

}  // namespace vsfind
