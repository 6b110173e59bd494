#include "acquisition/timestamp.h"

#include <fmt/format.h>

namespace vsfind {

std::string name(Clock clock) {
  switch (clock) {
    case Clock::monotonic:
      return "monotonic";
    case Clock::realtime:
      return "realtime";
    case Clock::device:
      return "device";
    case Clock::recording:
      return "recording";
    case Clock::none:
      break;
  }
  return "none";
}

std::string name(StampedAt stamped_at) {
  switch (stamped_at) {
    case StampedAt::start:
      return "start";
    case StampedAt::end:
      return "end";
    case StampedAt::unknown:
      break;
  }
  return "unknown";
}

std::string timestamp_text(Clock clock, StampedAt stamped_at) {
  if (clock == Clock::none) return "no timestamps";
  const char* moment = stamped_at == StampedAt::start ? " of the start of a frame"
                       : stamped_at == StampedAt::end ? " of the end of a frame"
                                                      : "";
  const std::string whose = clock == Clock::device      ? "the camera's clock"
                            : clock == Clock::recording ? "by the frame rate"
                                                        : name(clock) + " clock";
  return fmt::format("timestamps{} ({})", moment, whose);
}

}  // namespace vsfind
