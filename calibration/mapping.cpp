#include "calibration/mapping.h"

#include <string>

#include "acquisition/errors.h"

namespace vsfind {

Mapping Mapping::from_pixel_aspect(double aspect) {
  if (!(aspect >= 0.1 && aspect <= 10.0)) {
    throw UsageError("pixel aspect " + std::to_string(aspect) + " is out of range (allowed: 0.1 to 10)");
  }
  Mapping mapping;
  mapping.aspect_ = aspect;
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

Eigen::Vector2d Mapping::plane_from_image(const Eigen::Vector2d& image) const {
  const Eigen::Vector2d frame = frame_from_image(image);
  return {frame.x() * aspect_, frame.y()};
}

Eigen::Vector2d Mapping::image_from_plane(const Eigen::Vector2d& plane) const {
  return {plane.x() / aspect_, (plane.y() - first_line(field_)) / line_step(field_)};
}

Eigen::Matrix2d Mapping::image_from_plane_jacobian(const Eigen::Vector2d& /*plane*/) const {
  Eigen::Matrix2d jacobian;
  jacobian << 1.0 / aspect_, 0.0, 0.0, 1.0 / line_step(field_);
  return jacobian;
}

}  // namespace vsfind
