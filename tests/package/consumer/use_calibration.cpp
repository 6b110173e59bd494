// A field of a camera with wide pixels: to the plane and back.
#include <cmath>
#include <cstdio>

#include "calibration/mapping.h"

int main() {
  const auto mapping = vsfind::Mapping::from_pixel_aspect(1.2).for_field(vsfind::Field::bottom);
  const Eigen::Vector2d image(10.0, 5.0);
  const Eigen::Vector2d plane = mapping.plane_from_image(image);
  const Eigen::Vector2d back = mapping.image_from_plane(plane);
  if (std::abs(plane.x() - 12.0) > 1e-9 || std::abs(plane.y() - 11.0) > 1e-9 || (back - image).norm() > 1e-9) {
    std::fprintf(stderr, "plane %.3f %.3f, back %.3f %.3f\n", plane.x(), plane.y(), back.x(), back.y());
    return 1;
  }
  return 0;
}
