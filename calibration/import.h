#pragma once
/// @file
/// Lenses that other programs calibrated.

#include <string>

#include "calibration/calibration.h"

namespace vsfind {

struct ImportOptions {
  int camera =
      0;  ///< which one, where a file holds several (Kalibr's cam0, cam1, …; M1, M2, … of OpenCV's stereo files)
  int image_width = 0;  ///< of the pictures, where the file does not say it; else it must agree
  int image_height = 0;
  /// What the pictures are. Single fields: the file was made from such (its focal length and centre along y count a
  /// field's rows), or from whole frames where its images are twice as high as the pictures.
  Field field = Field::frame;
};

/// Reads the lens from a ROS camera_info YAML (plumb_bob, rational_polynomial, equidistant; a file or a message), an
/// OpenCV FileStorage YAML (camera_matrix, distortion_coefficients), hybrids of both, or a Kalibr camchain (radtan,
/// equidistant). The plane is the undistorted picture (undistorted_picture_plane()), unit px, until a view of a board
/// gives another one. Throws IoError where the file cannot be read, UsageError with file, line and key where it is none
/// of these, or holds no calibration, or one of a kind that vsfind does not know. What it gives is for whole frames.
[[nodiscard]] Calibration import_calibration(const std::string& path, const ImportOptions& options = {});

/// The same from the file's text.
[[nodiscard]] Calibration parse_foreign_calibration(const std::string& text, const std::string& file,
                                                    const ImportOptions& options = {});

}  // namespace vsfind
