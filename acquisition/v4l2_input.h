#pragma once
/// @file
/// The input of a V4L2 device, its video standard or timings, and whether a signal is there. Inside the V4L2 backend
/// only.

#include <string>

#include "acquisition/camera.h"
#include "acquisition/source.h"
#include "acquisition/v4l2_device.h"

namespace vsfind {

struct V4l2Input {
  std::uint32_t index = 0;
  std::string name;
  v4l2_std_id standard = 0;  ///< 0 where the input has none (webcams, HDMI)
  std::string standard_name;
  int standard_lines = 0;   ///< visible: 480 or 576
  bool lines_525 = false;   ///< the standard is one of 525 lines
  Ratio frame_rate;         ///< of standard or timings
  v4l2_bt_timings timings;  ///< all 0 where the input has none
};

/// Chooses input, standard and timings as asked, or else as the device stands and the signal is. Throws UsageError
/// that names what the device has, and CameraError where no signal is there.
[[nodiscard]] V4l2Input select_input(const V4l2Device& device, const CameraSettings& settings);

/// Why no usable picture comes from the current input ("no signal at input 'S-Video'"); empty where one does, or where
/// the device cannot tell.
[[nodiscard]] std::string signal_problem(const V4l2Device& device);

}  // namespace vsfind
