#pragma once
/// @file
/// Which mapping a source is searched through.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/source.h"
#include "app/values.h"
#include "calibration/calibration.h"
#include "finder/pattern.h"

namespace vsfind {

/// Where whole frames lie on the plane, and what its coordinates are.
struct SourceMapping {
  Mapping mapping;
  std::string unit = "px";
  std::optional<Calibration> calibration;  ///< that it comes from, where one was given
  bool asked_for = false;                  ///< by an option, not taken from the source or for want of anything better

  /// Throws UsageError where a calibration was made for frames of another size than this picture's.
  void check_size(int width, int height, Field field) const;
};

/// What is given for a source: at most one of the two.
struct MappingChoice {
  std::string calibration;  ///< file, "" for none
  std::optional<PixelAspect> pixel_aspect;
};

/// The calibration given, else the pixel aspect given, else what the source says of its pixels (`said`), else square
/// pixels; the log (info) says which. Throws as load_calibration; IoError where the source's own value is out of range.
[[nodiscard]] SourceMapping mapping_for(const std::string& source, const Ratio& said, const MappingChoice& choice);

/// Throws UsageError where a pattern was trained in another unit than it is searched in. Warns of a pattern trained
/// with another pixel aspect than that which the search goes by without having been told to.
void check_units(const std::vector<std::shared_ptr<const Pattern>>& patterns, const SourceMapping& mapping);

}  // namespace vsfind
