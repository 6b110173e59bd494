#pragma once
/// @file
/// V4L2 devices as sources; there where the build has libv4l2 (VSFIND_HAVE_V4L2).

#include <memory>
#include <string>
#include <vector>

#include "acquisition/camera.h"

namespace vsfind {

/// Opens a device ("/dev/video0") and starts it; its name is "v4l2:" + device. Throws CameraError, UsageError.
[[nodiscard]] std::unique_ptr<FrameSource> open_v4l2(const std::string& device, const CameraSettings& settings);

/// The capture devices of this machine.
[[nodiscard]] std::vector<CameraDescription> list_v4l2();

}  // namespace vsfind
