#include "finder/field_fit.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

namespace vsfind {

FitResult FieldFit::fit(const PatternSpline& spline, const PointArrays& around, const ImageView& image,
                        const Projection& projection, const FitOptions& options, PoseFit& fit, Pose& pose) {
  const auto n = static_cast<std::size_t>(around.count);
  u_.resize(n);
  v_.resize(n);
  projection.level_from_pattern(pose, around.x.data(), around.y.data(), around.count, u_.data(), v_.data());
  pixels_.clear();
  std::set<std::pair<long, long>> taken;
  for (std::size_t k = 0; k < n; ++k) {
    if (!(u_[k] > -0.5 && v_[k] > -0.5 && u_[k] < image.width - 0.5 && v_[k] < image.height - 0.5)) continue;
    const std::pair at(std::lround(u_[k]), std::lround(v_[k]));
    if (!taken.insert(at).second) continue;
    pixels_.push_back({static_cast<double>(at.first), static_cast<double>(at.second),
                       options.trusted == 0 || k < static_cast<std::size_t>(options.trusted)});
  }
  const PixelReader reader(image);
  FitOptions step = options;
  step.iterations = 1;
  step.at_start_only = true;
  FitResult result;
  Pose now = pose;
  constexpr int most_steps = 6;
  for (int i = 0; i < most_steps; ++i) {
    const double angle = now.angle_deg * std::numbers::pi / 180.0;
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    points_.clear();
    step.trusted = 0;
    for (const Pixel& pixel : pixels_) {
      const Eigen::Vector2d from_origin =
          (projection.mapping->plane_from_image({pixel.u, pixel.v}) - Eigen::Vector2d(now.x, now.y)) / projection.pitch;
      PatternPoint point;
      if (!spline.read((c * from_origin.x() + s * from_origin.y()) / now.scale_x,
                       (c * from_origin.y() - s * from_origin.x()) / now.scale_y, point)) {
        continue;
      }
      if (pixel.trusted) ++step.trusted;
      points_.push_back(point);
    }
    const Pose before = now;
    const FitResult next = fit.fit(PointArrays(points_), projection, reader, step, now);
    if (!next.ok) return result;
    result = next;
    step.start = {result.gain, result.offset};
    step.first_iteration = 2;
    const double moved = std::hypot(now.x - before.x, now.y - before.y) / projection.pitch;
    if (i >= 2 && moved < options.step_tolerance) break;
  }
  pose = now;
  return result;
}

}  // namespace vsfind
