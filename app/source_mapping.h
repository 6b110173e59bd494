#pragma once
/// @file
/// Which mapping a source is searched through.

#include <optional>

#include "acquisition/source.h"
#include "app/values.h"
#include "calibration/mapping.h"

namespace vsfind {

/// The mapping of whole frames: the pixel aspect given, else what the source says, else square pixels; the log (info)
/// says which. Throws IoError where the source's own value is out of range.
[[nodiscard]] Mapping mapping_for(const SourceInfo& source, const std::optional<PixelAspect>& given);

}  // namespace vsfind
