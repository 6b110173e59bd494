#pragma once
/// @file
/// A source that comes back: reopens a camera that is lost, for months of running.

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "acquisition/source.h"

namespace vsfind {

struct ReconnectOptions {
  std::chrono::milliseconds first_pause{100};  ///< before the second attempt to open; doubles from attempt to attempt
  std::chrono::milliseconds longest_pause{500};
  std::optional<std::chrono::milliseconds> give_up_after;  ///< without a camera for so long: next() throws CameraError
};

/// A source over `open`, which opens the camera (it throws CameraError, or gives a source whose next() throws it).
/// Nothing is opened before the first next(), so that a camera may be absent at first; info() holds `name` alone until
/// the first frame is there, and may change with every reopening. A source that ends by itself (a recording) ends this.
///
/// CameraError makes it reopen, with a growing pause; one event tells of the loss, one of the return. UsageError passes
/// while nothing was ever opened, afterwards it is taken like CameraError: settings that were right once do not end a
/// line because another camera was plugged in. Other errors pass.
///
/// Frames are counted on after a return, with a gap of as many as the camera would have given meanwhile: the time from
/// the last frame's arrival to the next one's, by the rate at which frames came before. One number at least is left
/// out; only one where frames come when they are triggered (no frame_rate in its info), or too few came to tell.
[[nodiscard]] std::unique_ptr<FrameSource> open_reconnecting(std::string name,
                                                             std::function<std::unique_ptr<FrameSource>()> open,
                                                             const ReconnectOptions& options = {});

}  // namespace vsfind
