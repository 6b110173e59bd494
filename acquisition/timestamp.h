#pragma once
/// @file
/// What a timestamp counts and tells, in words.

#include <string>

#include "acquisition/frame.h"

namespace vsfind {

/// "timestamps of the end of a frame (monotonic clock)"; "no timestamps" where there is no clock.
[[nodiscard]] std::string timestamp_text(Clock clock, StampedAt stamped_at);

/// "monotonic", "realtime", "device", "recording", "none".
[[nodiscard]] std::string name(Clock clock);
/// "start", "end", "unknown".
[[nodiscard]] std::string name(StampedAt stamped_at);

}  // namespace vsfind
