#include "calibration/mapping.h"

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <string>

#include "acquisition/errors.h"

namespace vsfind {
namespace {

Eigen::Vector2d nowhere() { return Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN()); }

void check_aspect(double aspect) {
  if (!(aspect >= 0.1 && aspect <= 10.0)) {
    throw UsageError("pixel aspect " + std::to_string(aspect) + " is out of range (allowed: 0.1 to 10)");
  }
}

Eigen::Vector2d through(const Eigen::Matrix3d& matrix, const Eigen::Vector2d& point) {
  const Eigen::Vector3d h = matrix.leftCols<2>() * point + matrix.col(2);
  return h.z() > 0.0 ? Eigen::Vector2d(h.head<2>() / h.z()) : nowhere();
}

}  // namespace

Mapping::Mapping() : out_from_plane_(Eigen::Matrix3d::Identity()), plane_from_out_(Eigen::Matrix3d::Identity()) {}

Mapping Mapping::from_pixel_aspect(double aspect) {
  check_aspect(aspect);
  Mapping mapping;
  mapping.aspect_ = aspect;
  mapping.out_from_plane_(0, 0) = 1.0 / aspect;
  mapping.plane_from_out_(0, 0) = aspect;
  return mapping;
}

Mapping Mapping::from_homography(const Eigen::Matrix3d& frame_from_plane, double pixel_aspect) {
  check_aspect(pixel_aspect);
  if (!frame_from_plane.allFinite()) throw UsageError("homography: its nine numbers must be finite");
  Mapping mapping;
  mapping.aspect_ = pixel_aspect;
  const Eigen::Matrix3d& h = frame_from_plane;
  const bool flat = h(2, 0) == 0.0 && h(2, 1) == 0.0 && h(2, 2) > 0.0;
  mapping.kind_ = flat ? Kind::affine : Kind::homography;
  mapping.out_from_plane_ = flat ? Eigen::Matrix3d(h / h(2, 2)) : h;
  mapping.plane_from_out_ = mapping.out_from_plane_.inverse();
  // Relative to the size of its rows, which may differ by orders of magnitude.
  const double volume = h.row(0).norm() * h.row(1).norm() * h.row(2).norm();
  if (!(std::abs(h.determinant()) > 1e-14 * volume) || !mapping.plane_from_out_.allFinite()) {
    throw UsageError("homography: its matrix cannot be inverted");
  }
  return mapping;
}

Mapping Mapping::from_lens(const Lens& lens, const PlanePose& plane) {
  const Eigen::Matrix3d& r = plane.rotation;
  if (!r.allFinite() || !plane.translation.allFinite())
    throw UsageError("plane: rotation and translation must be finite");
  if (!((r.transpose() * r - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-6) || !(r.determinant() > 0.0)) {
    throw UsageError("plane: rotation is not a rotation matrix");
  }
  Mapping mapping;
  mapping.kind_ = Kind::lens;
  mapping.aspect_ = lens.camera().fy / lens.camera().fx;
  check_aspect(mapping.aspect_);
  mapping.lens_ = lens;
  mapping.out_from_plane_ << r.col(0), r.col(1), plane.translation;
  const double distance = std::abs(r.col(2).dot(plane.translation));
  if (!(distance > 1e-9 * plane.translation.norm())) throw UsageError("plane: runs through the camera");
  mapping.plane_from_out_ = mapping.out_from_plane_.inverse();
  return mapping;
}

Mapping Mapping::for_field(Field field) const {
  Mapping mapping = *this;
  mapping.field_ = field;
  return mapping;
}

Eigen::Vector2d Mapping::frame_from_image(const Eigen::Vector2d& image) const {
  return {image.x(), image.y() * line_step(field_) + first_line(field_)};
}

Eigen::Vector2d Mapping::image_from_frame(const Eigen::Vector2d& frame) const {
  return {frame.x(), (frame.y() - first_line(field_)) / line_step(field_)};
}

Eigen::Vector2d Mapping::plane_from_image(const Eigen::Vector2d& image) const {
  const Eigen::Vector2d frame = frame_from_image(image);
  return through(plane_from_out_, kind_ == Kind::lens ? lens_.ray_from_pixel(frame) : frame);
}

Eigen::Vector2d Mapping::image_from_plane(const Eigen::Vector2d& plane) const {
  const Eigen::Vector2d out = through(out_from_plane_, plane);
  return image_from_frame(kind_ == Kind::lens ? lens_.pixel_from_ray(out) : out);
}

Eigen::Matrix2d Mapping::image_from_plane_jacobian(const Eigen::Vector2d& plane) const {
  const Eigen::Vector3d h = out_from_plane_.leftCols<2>() * plane + out_from_plane_.col(2);
  if (!(h.z() > 0.0)) return Eigen::Matrix2d::Constant(std::numeric_limits<double>::quiet_NaN());
  const Eigen::Vector2d out = h.head<2>() / h.z();
  Eigen::Matrix2d j = (out_from_plane_.topLeftCorner<2, 2>() - out * out_from_plane_.bottomLeftCorner<1, 2>()) / h.z();
  if (kind_ == Kind::lens) j = (lens_.pixel_from_ray_jacobian(out) * j).eval();
  j.row(1) /= line_step(field_);
  return j;
}

}  // namespace vsfind
