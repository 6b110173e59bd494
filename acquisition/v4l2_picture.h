#pragma once
/// @file
/// Size, pixel format, field order, crop, frame rate and pixel shape of a V4L2 device. Inside the V4L2 backend only.

#include <vector>

#include "acquisition/camera.h"
#include "acquisition/source.h"
#include "acquisition/v4l2_device.h"
#include "acquisition/v4l2_fields.h"
#include "acquisition/v4l2_input.h"

namespace vsfind {

struct V4l2Picture {
  V4l2Format format;  ///< of a buffer, as the driver has it
  BufferFields fields = BufferFields::none;
  Ratio pixel_aspect;  ///< width : height of a pixel of the whole frame
  Ratio frame_rate;
};

/// Sets what is asked for, and reads all of it back. Throws UsageError that names what the device can do, and
/// CameraError.
[[nodiscard]] V4l2Picture set_picture(const V4l2Device& device, const V4l2Input& input, const CameraSettings& settings);

/// The pixel formats of the current input.
[[nodiscard]] std::vector<v4l2_fmtdesc> pixel_formats(const V4l2Device& device);
/// The frame rates of a format and size, highest first; `is_range` tells that they are the ends of one.
[[nodiscard]] std::vector<double> frame_rates(const V4l2Device& device, std::uint32_t fourcc, std::uint32_t width,
                                              std::uint32_t height, bool& is_range);

}  // namespace vsfind
