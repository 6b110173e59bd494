#pragma once
/// @file
/// A calibration as a YAML file that a person can read and edit. For example
///
///     vsfind_calibration: 2            # version of this format
///     checksum: "7d3f0c1a"             # of all other lines but their comments; may be left out
///     unit: mm                         # of plane coordinates
///     image_size: [720, 576]           # of the whole frame, pixels; left out: any size
///     made_from: frame                 # frame, top or bottom: what the pictures held
///     pixel_aspect: 1.0925925925925926 # pixel width over pixel height
///     lens:
///       model: polynomial              # or fisheye
///       focal_length: [1041.2, 1137.6] # fx, fy in frame pixels
///       principal_point: [361.5, 287.9]
///       distortion: [-0.21, 0.09, 0.0003, -0.0001, 0.0]  # see lens.h for order and meaning
///     plane:                           # camera = R(rotation) · (x, y, 0) + translation
///       rotation: [0.52, 0.01, 0.0]    # axis times angle, radians (Rodrigues)
///       translation: [-40.5, -22.1, 512.3]  # in the plane's unit
///     residuals: {points: 54, rms: 0.04, worst: 0.11, views: [{name: a.png, points: 54, rms: 0.04, worst: 0.11}]}
///
/// Instead of lens and plane there may be `homography: [[…], […], […]]`, frame pixels from plane coordinates, its third
/// row positive where the plane is visible; or neither.
///
/// A file whose checksum does not suit the rest is refused. Version 1 had none.

#include <string>

#include "calibration/calibration.h"

namespace vsfind {

/// The version that this program writes, and the newest that it reads.
inline constexpr int calibration_file_version = 2;

/// The file's text.
[[nodiscard]] std::string calibration_text(const Calibration& calibration);
/// Reads it; `file` is named in complaints. Throws UsageError: `file:line: key: what is wrong (allowed: …)`.
[[nodiscard]] Calibration parse_calibration(const std::string& text, const std::string& file);

/// Writes the whole file or nothing. Throws IoError.
void save_calibration(const Calibration& calibration, const std::string& path);
/// Throws IoError where the file cannot be read, UsageError where it is no calibration of a known version.
[[nodiscard]] Calibration load_calibration(const std::string& path);

}  // namespace vsfind
