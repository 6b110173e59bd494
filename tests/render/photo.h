#pragma once
/// @file
/// Photographs resampled with exactly known pose. The photograph is taken for a continuous picture (Catmull-Rom cubic
/// interpolation in double precision) of higher resolution than the result, and every pixel of the result is the mean
/// of it over the pixel's square, by 8 × 8 samples.

#include "acquisition/image_view.h"
#include "app/render/scene.h"
#include "finder/pose.h"

namespace vsfind::render {

/// A continuous picture made of a photograph; beyond its border the border goes on.
class Photo {
 public:
  explicit Photo(const ImageView& pixels);
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  /// Grey level (of 255) at any point, photo pixels.
  [[nodiscard]] double at(double x, double y) const;

 private:
  int width_;
  int height_;
  std::vector<double> grey_;
};

/// A picture of the photo: the photo's point `centre` lies where `pose` says, angle and scales as a pose's, `reduction`
/// (2 or more for a photo that is sharp to its pixels) photo pixels to a pixel at scale 1.
[[nodiscard]] Exposure expose_photo(const Photo& photo, const Eigen::Vector2d& centre, double reduction,
                                    const Pose& pose, int width, int height);

/// Where in an exposure a square of `size` pixels has the most structure in its weakest direction: the ROI that a
/// person would choose. Looks only `margin` pixels and more from the border.
[[nodiscard]] Roi richest_roi(const Exposure& exposure, int size, int margin);

}  // namespace vsfind::render
