#pragma once
/// @file
/// GigE Vision cameras as sources; there where the build has Aravis (VSFIND_HAVE_ARAVIS).

#include <memory>
#include <string>
#include <vector>

#include "acquisition/camera.h"

namespace vsfind {

/// Opens a camera by its name (as list_gige gives it, or as its user set it), serial number, or network address, the
/// first one found where `name` is empty, and starts it; its name is "gige:" + name. Throws CameraError, UsageError.
[[nodiscard]] std::unique_ptr<FrameSource> open_gige(const std::string& name, const CameraSettings& settings);

/// The cameras that answer on the network; asks each for its formats unless `details` is false. Takes about a second.
[[nodiscard]] std::vector<CameraDescription> list_gige(bool details = true);

/// Aravis' and GLib's part of log_camera_libraries().
void log_gige_library();

}  // namespace vsfind
