#pragma once
/// @file
/// How cameras are set on the command line and in a configuration: one struct behind both, of `live` and `record`.

#include <vector>

#include "acquisition/camera.h"
#include "app/settings.h"

namespace vsfind {

/// The settings that fill `camera`, which must outlive them.
[[nodiscard]] std::vector<Setting> camera_settings(CameraSettings& camera);

}  // namespace vsfind
