#pragma once
/// @file
/// Cameras as text: a line each, or JSON with all that is known.

#include <string>
#include <vector>

#include "acquisition/camera.h"

namespace vsfind {

/// The URI first, then model, serial number, formats with sizes and rates, and why it cannot be opened now.
[[nodiscard]] std::string camera_line(const CameraDescription& camera);

/// An array of objects, indented. Sizes are objects with width and height, or with their ranges and steps.
[[nodiscard]] std::string cameras_json(const std::vector<CameraDescription>& cameras);

}  // namespace vsfind
