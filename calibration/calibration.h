#pragma once
/// @file
/// What a calibration knows of a camera and a plane, whatever it was made from.

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/image_view.h"
#include "calibration/lens.h"
#include "calibration/mapping.h"

namespace vsfind {

/// How far detected points lie from where the calibration puts them, frame pixels.
struct ViewResidual {
  std::string name;  ///< the picture's file, or the list of points
  int points = 0;
  double rms = 0.0;    ///< of the distances
  double worst = 0.0;  ///< the largest distance
};
struct Residuals {
  int points = 0;
  double rms = 0.0;
  double worst = 0.0;
  std::vector<ViewResidual> views;
};

/// One of: a lens and a plane; a homography; neither, then the pixel aspect alone.
struct Calibration {
  std::string unit = "px";         ///< of plane coordinates
  int image_width = 0;             ///< of the whole frame, pixels; 0: any size (pixel aspect alone)
  int image_height = 0;            ///< of the whole frame, rows
  Field made_from = Field::frame;  ///< what the pictures held; all numbers here are for the whole frame all the same
  double pixel_aspect = 1.0;       ///< pixel width over pixel height; with a lens fy/fx
  std::optional<Lens> lens;
  std::optional<PlanePose> plane;             ///< beside a lens
  std::optional<Eigen::Matrix3d> homography;  ///< frame_from_plane, third component positive where the plane is visible
  Residuals residuals;
  std::string file;  ///< where it was loaded from, for complaints; else empty
};

/// The mapping between whole frames and the plane; `for_field` of it serves single fields. Throws UsageError where the
/// numbers are impossible.
[[nodiscard]] Mapping mapping_of(const Calibration& calibration);

/// Makes sure that a picture of `width` x `height` that holds `field` comes from frames of the calibration's size.
/// Frames and single fields of the same camera both fit. Throws UsageError that names both sizes.
void check_fits(const Calibration& calibration, int width, int height, Field field);

/// A calibration that knows nothing but the shape of a pixel. Throws UsageError unless 0.1 <= aspect <= 10.
[[nodiscard]] Calibration calibration_from_pixel_aspect(double aspect);

/// A lens without a plane: the plane is then the picture without its distortion. Its unit is one frame row (px), pixels
/// are square in it, and straight ahead it lies where the frame does: plane = (a·x, y) at the principal point, a =
/// fy/fx.
[[nodiscard]] PlanePose undistorted_picture_plane(const Lens& lens);

}  // namespace vsfind
