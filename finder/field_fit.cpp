#include "finder/field_fit.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "finder/point_block.h"
#include "finder/training_scene.h"

namespace vsfind {

namespace {

/// What was read before, whatever the places.
class KnownReader final : public Reader {
 public:
  explicit KnownReader(const std::vector<float>& values) : values_(values) {}
  void read(const Places& /*places*/, int count, float* out, float* inside) const override {
    std::copy(values_.begin(), values_.end(), out);
    std::fill_n(out + values_.size(), kernels::padded(count) - count, 0.0F);
    std::fill_n(inside, count, 1.0F);
  }

 private:
  const std::vector<float>& values_;
};

Eigen::Matrix2d plane_from_pattern_slope(const Pose& pose) {
  return Eigen::Rotation2Dd(pose.angle_deg * std::numbers::pi / 180.0).toRotationMatrix() *
         Eigen::Vector2d(pose.scale_x, pose.scale_y).asDiagonal();
}

/// The values of a point a little way off, by its derivatives.
PatternPoint moved(const PatternPoint& p, double x, double y) {
  const auto dx = static_cast<float>(x - p.x);
  const auto dy = static_cast<float>(y - p.y);
  const float xx = 0.5F * (p.laplacian + p.stretch);
  const float yy = 0.5F * (p.laplacian - p.stretch);
  const float xy = 0.5F * p.shear;
  PatternPoint to = p;
  to.x = x;
  to.y = y;
  to.value += dx * (p.gradient_x + 0.5F * xx * dx + xy * dy) + dy * (p.gradient_y + 0.5F * yy * dy);
  to.gradient_x += xx * dx + xy * dy;
  to.gradient_y += xy * dx + yy * dy;
  return to;
}

}  // namespace

bool FieldFit::pays(const Projection& projection, const Pose& pose) {
  constexpr double apart = 1.3;  // pattern pixels: then the kernel of the other way spans enough lines
  const Eigen::Vector2d image = projection.mapping->image_from_plane({pose.x, pose.y});
  const double scale = std::sqrt(pose.scale_x * pose.scale_y);
  return pixel_size(*projection.mapping, image).y() > apart * projection.pitch * scale;
}

void FieldFit::gather(const PointArrays& around, const ImageView& image, const Projection& projection, int trusted,
                      const Pose& pose) {
  const auto n = static_cast<std::size_t>(around.count);
  u_.resize(n);
  v_.resize(n);
  projection.level_from_pattern(pose, around.x.data(), around.y.data(), around.count, u_.data(), v_.data());
  const Eigen::Matrix2d level_from_pattern =
      projection.level_from_plane_jacobian({pose.x, pose.y}) * plane_from_pattern_slope(pose) * projection.pitch;
  const Eigen::Matrix2d pattern_from_level = level_from_pattern.inverse();
  const auto place_of = [&](int column, int row) {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(column);
  };
  taken_.resize(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height), 0);
  pixels_.clear();
  x_.clear();
  y_.clear();
  trusted_ = 0;
  const double to_255 = 255.0 / (255.0 * std::ldexp(1.0, std::max(0, image.bits - 8)));
  constexpr int beside = 1;  // columns to either side
  for (std::size_t k = 0; k < n; ++k) {
    if (!(u_[k] > -0.5 && v_[k] > -0.5 && u_[k] < image.width - 0.5 && v_[k] < image.height - 0.5)) continue;
    const auto column = static_cast<int>(std::lround(u_[k]));
    const auto line = static_cast<int>(std::floor(v_[k]));
    for (int row = std::max(0, line); row <= std::min(image.height - 1, line + 1); ++row) {
      for (int c = std::max(0, column - beside); c <= std::min(image.width - 1, column + beside); ++c) {
        std::uint8_t& taken = taken_[place_of(c, row)];
        if (taken != 0) continue;
        taken = 1;
        pixels_.push_back({c, row, static_cast<float>(to_255 * image.at(c, row))});
        const Eigen::Vector2d at =
            Eigen::Vector2d(around.x[k], around.y[k]) + pattern_from_level * Eigen::Vector2d(c - u_[k], row - v_[k]);
        x_.push_back(at.x());
        y_.push_back(at.y());
        if (static_cast<int>(k) < trusted) ++trusted_;
      }
    }
  }
  // Only what was marked: the picture may be large.
  for (const Pixel& pixel : pixels_) taken_[place_of(pixel.column, pixel.row)] = 0;
  if (!projection.mapping->affine()) settle(projection, pose, pattern_from_level);
}

void FieldFit::settle(const Projection& projection, const Pose& pose, const Eigen::Matrix2d& pattern_from_level) {
  const std::size_t n = pixels_.size();
  u_.resize(n);
  v_.resize(n);
  constexpr int rounds = 3;  // each leaves a tenth or less, as far as the slope in the middle holds
  for (int round = 0; round < rounds; ++round) {
    projection.level_from_pattern(pose, x_.data(), y_.data(), static_cast<int>(n), u_.data(), v_.data());
    for (std::size_t k = 0; k < n; ++k) {
      const Eigen::Vector2d off =
          pattern_from_level * Eigen::Vector2d(pixels_[k].column - u_[k], pixels_[k].row - v_[k]);
      x_[k] += off.x();
      y_[k] += off.y();
    }
  }
}

void FieldFit::read_pattern(const PatternSpline& spline, double pitch, const Pose& gathered, const Pose& now,
                            bool anew) {
  const std::size_t n = pixels_.size();
  // The pixels stay where they are on the plane.
  const Eigen::Matrix2d back = plane_from_pattern_slope(now).inverse();
  const Eigen::Matrix2d turn = back * plane_from_pattern_slope(gathered);
  const Eigen::Vector2d shift = back * Eigen::Vector2d(gathered.x - now.x, gathered.y - now.y) / pitch;
  read_.resize(n);
  seen_.resize(n);
  points_.clear();
  greys_.clear();
  trusted_points_ = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const double x = turn(0, 0) * x_[k] + turn(0, 1) * y_[k] + shift.x();
    const double y = turn(1, 0) * x_[k] + turn(1, 1) * y_[k] + shift.y();
    if (anew) seen_[k] = spline.read(x, y, read_[k]) ? 1 : 0;
    if (seen_[k] == 0) continue;
    points_.push_back(moved(read_[k], x, y));
    greys_.push_back(pixels_[k].grey);
    if (static_cast<int>(k) < trusted_) ++trusted_points_;
  }
  arrays_.assign(points_);
}

FitResult FieldFit::fit(const PatternSpline& spline, const PointArrays& around, const ImageView& image,
                        const Projection& projection, const FitOptions& options, PoseFit& fit, Pose& pose) {
  gather(around, image, projection, options.trusted > 0 ? options.trusted : around.count, pose);
  const KnownReader reader(greys_);
  FitOptions step = options;
  step.iterations = 1;
  step.at_start_only = true;
  FitResult result;
  Pose now = pose;
  Pose read_at = pose;
  // Points in units of the pattern's pixels: what a turn or a growth moves the farthest one by.
  const auto distance = [&](const Pose& a, const Pose& b) {
    return std::hypot(a.x - b.x, a.y - b.y) / projection.pitch +
           around.radius * (std::abs(std::remainder(a.angle_deg - b.angle_deg, 360.0)) * std::numbers::pi / 180.0 +
                            std::abs(a.scale_x - b.scale_x) + std::abs(a.scale_y - b.scale_y));
  };
  constexpr int most_steps = 6;
  constexpr double near = 0.1;  // pattern pixels: so far the derivatives carry
  for (int i = 0; i < most_steps; ++i) {
    const bool anew = i == 0 || distance(now, read_at) > near;
    read_pattern(spline, projection.pitch, pose, now, anew);
    if (anew) read_at = now;
    const Pose before = now;
    step.trusted = trusted_points_;
    const FitResult next = fit.fit(arrays_, projection, reader, step, now);
    if (!next.ok) return result;
    result = next;
    step.start = {result.gain, result.offset};
    step.first_iteration = 2;
    if (i >= 1 && distance(now, before) < options.step_tolerance) break;
  }
  pose = now;
  return result;
}

}  // namespace vsfind
