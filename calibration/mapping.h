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
///
/// Where there is no answer (the plane point is behind the camera, the image point looks above the horizon of the plane
/// or lies outside what the lens model reaches, see lens.h) both coordinates of the answer are NaN, and so is every
/// entry of the Jacobian. A plane point near the horizon may project very far away. So a caller asks `x >= 0 && x <=
/// width - 1` before it uses a projected point; that is false for NaN too.

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "acquisition/image_view.h"
#include "calibration/lens.h"

namespace vsfind {

/// The plane in the camera's frame: camera = rotation · (x, y, 0) + translation, in plane units, Z forward.
struct PlanePose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::UnitZ();
};

/// plane = linear · (x, y) + offset, from local (pattern) coordinates: a pose at work.
struct PlaneFromLocal {
  Eigen::Matrix2d linear = Eigen::Matrix2d::Identity();
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();
};

/// From a frame pixel to the plane and back. Immutable and free of state, so one may serve many threads.
class Mapping {
 public:
  /// Plain pixels: the plane is the frame.
  Mapping();
  /// Pixels `aspect` times as wide as high: plane = (aspect·x, y). Throws UsageError unless 0.1 <= aspect <= 10.
  [[nodiscard]] static Mapping from_pixel_aspect(double aspect);
  /// Perspective without a lens: (u, v, w) = frame_from_plane · (x, y, 1), frame pixel (u/w, v/w), the plane being
  /// visible where w > 0: the matrix's sign matters. Throws UsageError where the matrix is not finite or cannot be
  /// inverted, or the aspect (for the record only) is out of range.
  [[nodiscard]] static Mapping from_homography(const Eigen::Matrix3d& frame_from_plane, double pixel_aspect = 1.0);
  /// A plane seen through a lens. The pixel aspect is fy/fx. Throws UsageError where the rotation is none (off by more
  /// than 1e-6), or the plane runs through the camera.
  [[nodiscard]] static Mapping from_lens(const Lens& lens, const PlanePose& plane);

  /// The same mapping as seen by a single field of the camera (or by the whole frame again).
  [[nodiscard]] Mapping for_field(Field field) const;
  [[nodiscard]] Field field() const { return field_; }

  [[nodiscard]] Eigen::Vector2d plane_from_image(const Eigen::Vector2d& image) const;
  [[nodiscard]] Eigen::Vector2d image_from_plane(const Eigen::Vector2d& plane) const;
  [[nodiscard]] Eigen::Vector2d frame_from_image(const Eigen::Vector2d& image) const;
  [[nodiscard]] Eigen::Vector2d image_from_frame(const Eigen::Vector2d& frame) const;
  /// Derivative of image_from_plane at a plane point: column 0 is the image step for a unit step along plane x.
  [[nodiscard]] Eigen::Matrix2d image_from_plane_jacobian(const Eigen::Vector2d& plane) const;

  /// Many points at once, vectorized: local points (x[i], y[i]) go through `pose` to the plane and on to the image. The
  /// pose costs nothing extra. All four spans have the same length and do not overlap (checked: UsageError for the
  /// lengths). Computed in double whatever the storage; equal to the single-point form within rounding.
  void image_from_local(const PlaneFromLocal& pose, std::span<const double> x, std::span<const double> y,
                        std::span<double> image_x, std::span<double> image_y) const;
  void image_from_local(const PlaneFromLocal& pose, std::span<const float> x, std::span<const float> y,
                        std::span<float> image_x, std::span<float> image_y) const;
  /// The same for plane points themselves.
  void image_from_plane(std::span<const double> x, std::span<const double> y, std::span<double> image_x,
                        std::span<double> image_y) const {
    image_from_local({}, x, y, image_x, image_y);
  }
  void image_from_plane(std::span<const float> x, std::span<const float> y, std::span<float> image_x,
                        std::span<float> image_y) const {
    image_from_local({}, x, y, image_x, image_y);
  }

  /// Whether one Jacobian holds everywhere (and every point has an answer).
  [[nodiscard]] bool affine() const { return kind_ == Kind::affine; }
  /// Whether straight lines of the plane are bent in the image.
  [[nodiscard]] bool distorts() const { return kind_ == Kind::lens && lens_.distorts(); }
  [[nodiscard]] double pixel_aspect() const { return aspect_; }
  /// Whether all numbers are the same: what was computed for the one holds for the other.
  [[nodiscard]] bool operator==(const Mapping& other) const = default;

 private:
  enum class Kind : std::uint8_t { affine, homography, lens };
  template <typename Real>
  void project_many(const PlaneFromLocal& pose, std::span<const Real> x, std::span<const Real> y,
                    std::span<Real> image_x, std::span<Real> image_y) const;

  Kind kind_ = Kind::affine;
  Field field_ = Field::frame;
  double aspect_ = 1.0;
  Eigen::Matrix3d out_from_plane_;  ///< to frame pixels, or with a lens to rays
  Eigen::Matrix3d plane_from_out_;  ///< its inverse, third component positive for visible points
  Lens lens_;
};

}  // namespace vsfind
