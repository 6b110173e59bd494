#pragma once
/// @file
/// The controls of a V4L2 device: exposure, gain, and any other by its name. Inside the V4L2 backend only.

#include "acquisition/camera.h"
#include "acquisition/v4l2_device.h"

namespace vsfind {

/// Sets exposure, gain and the controls by name. Names are compared without regard to case, spaces and punctuation, so
/// that "White Balance, Automatic" and v4l2-ctl's white_balance_automatic are the same. A value is a whole number
/// (also 0x…), on or off, the text or number of a menu's entry, a text, or anything for a button. Throws UsageError
/// that names what the device has and allows, CameraError where it fails.
void set_controls(const V4l2Device& device, const CameraSettings& settings);

}  // namespace vsfind
