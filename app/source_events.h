#pragma once
/// @file
/// What a camera tells of itself, as lines of the log.

#include "acquisition/source.h"

namespace vsfind {

/// Faults and recoveries become warnings, notes appear with --verbose.
void log_source_events(FrameSource& source);

}  // namespace vsfind
