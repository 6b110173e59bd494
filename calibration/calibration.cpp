#include "calibration/calibration.h"

#include <fmt/format.h>

#include "acquisition/errors.h"

namespace vsfind {

Mapping mapping_of(const Calibration& calibration) {
  if (calibration.lens) {
    return Mapping::from_lens(*calibration.lens,
                              calibration.plane ? *calibration.plane : undistorted_picture_plane(*calibration.lens));
  }
  if (calibration.homography) return Mapping::from_homography(*calibration.homography, calibration.pixel_aspect);
  return Mapping::from_pixel_aspect(calibration.pixel_aspect);
}

void check_fits(const Calibration& calibration, int width, int height, Field field) {
  const int frame_width = calibration.image_width;
  const int frame_height = calibration.image_height;
  if (frame_width == 0 && frame_height == 0) return;
  const auto rows = [frame_height](Field of) {
    return of == Field::frame ? frame_height : of == Field::top ? (frame_height + 1) / 2 : frame_height / 2;
  };
  if (width == frame_width && height == rows(field)) return;
  const std::string what = field == Field::frame ? "frame" : fmt::format("{} field", name(field));
  std::string hint;
  if (width == frame_width && field == Field::frame && (height == rows(Field::top) || height == rows(Field::bottom))) {
    hint = "; for single fields say which one: top or bottom";
  } else if (width == frame_width && field != Field::frame && height == frame_height) {
    hint = "; it is as large as a whole frame";
  }
  throw UsageError(fmt::format("{}: is for frames of {}x{} (fields of {}x{}), but the image is a {} of {}x{}{}",
                               calibration.file.empty() ? "the calibration" : calibration.file, frame_width,
                               frame_height, frame_width, rows(field == Field::bottom ? Field::bottom : Field::top),
                               what, width, height, hint));
}

Calibration calibration_from_pixel_aspect(double aspect) {
  Calibration calibration;
  calibration.pixel_aspect = Mapping::from_pixel_aspect(aspect).pixel_aspect();
  return calibration;
}

PlanePose undistorted_picture_plane(const Lens& lens) {
  const PinholeCamera& c = lens.camera();
  // ray = ((X − a·cx)/fy, (Y − cy)/fy): rows keep their height, columns are stretched to square pixels.
  PlanePose plane;
  plane.translation = {-c.cx * c.fy / c.fx, -c.cy, c.fy};
  return plane;
}

}  // namespace vsfind
