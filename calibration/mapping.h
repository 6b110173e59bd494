#pragma once
/// @file
/// Where an image point lies in the world: the mapping that the finder searches through.
///
/// Three coordinate frames meet here.
///  - image: pixels of the picture that is searched, x right, y down, integers at pixel centres. If the picture is a
///    single field, y counts the field's own rows.
///  - frame: pixels of the whole frame. Row r of the top field is frame row 2r, of the bottom field 2r+1.
///  - plane: calibrated coordinates (mm on the plane; without a calibration a·x, y with pixel aspect a = width/height).
///
/// Directions are in the names: `plane_from_image(p)` takes an image point and gives a plane point.

#include <Eigen/Core>

#include "acquisition/image_view.h"

namespace vsfind {

/// From a frame pixel to the plane and back. Immutable and free of state, so one may serve many threads.
class Mapping {
 public:
  /// Plain pixels: the plane is the frame.
  Mapping() = default;
  /// Pixels `aspect` times as wide as high: plane = (aspect·x, y). Throws UsageError unless 0.1 <= aspect <= 10.
  [[nodiscard]] static Mapping from_pixel_aspect(double aspect);

  /// The same mapping as seen by a single field of the camera (or by the whole frame again).
  [[nodiscard]] Mapping for_field(Field field) const;
  [[nodiscard]] Field field() const { return field_; }

  [[nodiscard]] Eigen::Vector2d plane_from_image(const Eigen::Vector2d& image) const;
  [[nodiscard]] Eigen::Vector2d image_from_plane(const Eigen::Vector2d& plane) const;
  [[nodiscard]] Eigen::Vector2d frame_from_image(const Eigen::Vector2d& image) const;
  /// Derivative of image_from_plane at a plane point: column 0 is the image step for a unit step along plane x.
  [[nodiscard]] Eigen::Matrix2d image_from_plane_jacobian(const Eigen::Vector2d& plane) const;

  /// Whether one Jacobian holds everywhere.
  [[nodiscard]] bool affine() const { return true; }
  [[nodiscard]] double pixel_aspect() const { return aspect_; }

 private:
  double aspect_ = 1.0;
  Field field_ = Field::frame;
};

}  // namespace vsfind
