#include "finder/training_scene.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

namespace vsfind {

Eigen::Vector2d pixel_size(const Mapping& mapping, const Eigen::Vector2d& image) {
  const Eigen::Matrix2d plane_from_image = mapping.image_from_plane_jacobian(mapping.plane_from_image(image)).inverse();
  return {plane_from_image.col(0).norm(), plane_from_image.col(1).norm()};
}

GaussianReader gaussian_reader(const ImageView& image, const Mapping& mapping, const Eigen::Vector2d& image_point,
                               double pitch, double scale) {
  const Eigen::Vector2d pixel = pixel_size(mapping, image_point);
  constexpr double least = 0.7;  // below, pixels are read one by one and aliasing comes back
  constexpr double most = 1.3;   // above, 8 taps cut the bell off
  return {image, std::clamp(reading_sigma * scale * pitch / pixel.x(), least, most),
          std::clamp(reading_sigma * scale * pitch / pixel.y(), least, most)};
}

TrainingScene::TrainingScene(const ImageView& image, Mapping mapping, const TrainOptions& options, int levels)
    : image_(image), mapping_(std::move(mapping)), roi_(options.roi), mask_(options.mask) {
  const Eigen::Vector2d centre(roi_.x + (roi_.width - 1) / 2.0, roi_.y + (roi_.height - 1) / 2.0);
  const Eigen::Vector2d pixel = pixel_size(mapping_, centre);
  pitch_ = pixel.minCoeff();
  plan_ = HalvingPlan::for_pixel_size(pixel.x(), pixel.y(), levels);
  pyramid_.build(image_, plan_);
  const Eigen::Vector2d origin = mapping_.plane_from_image(options.origin.value_or(centre));
  pose_.x = origin.x();
  pose_.y = origin.y();
  const double x0 = roi_.x - 0.5;
  const double y0 = roi_.y - 0.5;
  double right = -1e300;
  double bottom = -1e300;
  left_ = 1e300;
  top_ = 1e300;
  for (const Eigen::Vector2d& corner :
       {Eigen::Vector2d(x0, y0), Eigen::Vector2d(x0 + roi_.width, y0), Eigen::Vector2d(x0, y0 + roi_.height),
        Eigen::Vector2d(x0 + roi_.width, y0 + roi_.height)}) {
    const Eigen::Vector2d p = (mapping_.plane_from_image(corner) - origin) / pitch_;
    left_ = std::min(left_, p.x());
    right = std::max(right, p.x());
    top_ = std::min(top_, p.y());
    bottom = std::max(bottom, p.y());
  }
  width_ = right - left_;
  height_ = bottom - top_;
}

bool TrainingScene::masked_in(double x, double y) const {
  const Eigen::Vector2d p = mapping_.image_from_plane({pose_.x + pitch_ * x, pose_.y + pitch_ * y});
  constexpr double edge = 0.5 + 1e-6;
  if (!(p.x() > roi_.x - edge && p.y() > roi_.y - edge && p.x() < roi_.x + roi_.width - 1 + edge &&
        p.y() < roi_.y + roi_.height - 1 + edge)) {
    return false;
  }
  if (mask_.empty()) return true;
  const bool of_roi = mask_.width == roi_.width && mask_.height == roi_.height;
  const int u = static_cast<int>(std::lround(p.x())) - (of_roi ? roi_.x : 0);
  const int v = static_cast<int>(std::lround(p.y())) - (of_roi ? roi_.y : 0);
  return mask_.at(std::clamp(u, 0, mask_.width - 1), std::clamp(v, 0, mask_.height - 1)) != 0;
}

bool TrainingScene::in_pattern(double x, double y, double reach) const {
  if (!masked_in(x, y)) return false;
  if (reach <= 0.0) return true;
  for (const double dy : {-reach, 0.0, reach}) {
    for (const double dx : {-reach, 0.0, reach}) {
      if ((dx != 0.0 || dy != 0.0) && !masked_in(x + dx, y + dy)) return false;
    }
  }
  return true;
}

std::vector<Eigen::Vector2d> TrainingScene::lattice(double step, double reach) const {
  std::vector<Eigen::Vector2d> points;
  const int columns = std::max(1, static_cast<int>(std::floor(width_ / step + 1e-9)));
  const int rows = std::max(1, static_cast<int>(std::floor(height_ / step + 1e-9)));
  const double x0 = left_ + (width_ - (columns - 1) * step) / 2.0;
  const double y0 = top_ + (height_ - (rows - 1) * step) / 2.0;
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const Eigen::Vector2d p(x0 + c * step, y0 + r * step);
      if (in_pattern(p.x(), p.y(), reach)) points.push_back(p);
    }
  }
  return points;
}

GaussianReader TrainingScene::gaussian() const {
  return gaussian_reader(image_, mapping_, {roi_.x + roi_.width / 2.0, roi_.y + roi_.height / 2.0}, pitch_, 1.0);
}

}  // namespace vsfind
