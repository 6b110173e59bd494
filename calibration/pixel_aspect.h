#pragma once
/// @file
/// Pixel shapes by name and as a ratio.

#include <string>

namespace vsfind {

/// Width of a pixel over its height for 625-line video sampled at 13.5 MHz (ITU-R BT.601): 59:54.
inline constexpr double pal_pixel_aspect = 59.0 / 54.0;
/// The same for 525-line video: 10:11, the usual round value.
inline constexpr double ntsc_pixel_aspect = 10.0 / 11.0;

/// Reads `pal`, `ntsc` or `W:H` (pixel width to pixel height, decimals allowed, e.g. 59:54 or 1:1).
/// Throws UsageError, naming the text and the allowed values, unless 0.1 <= W/H <= 10.
[[nodiscard]] double pixel_aspect_from_text(const std::string& text);

}  // namespace vsfind
