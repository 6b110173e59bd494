#include "calibration/lens.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "acquisition/errors.h"
#include "calibration/distortion.h"

namespace vsfind {
namespace {

// Rays steeper than this are taken for parallel to the sensor.
constexpr double steepest_angle = 89.9 * std::numbers::pi / 180.0;

Eigen::Vector2d nowhere() { return Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN()); }

// The radial part alone: distorted radius of a radius, and its derivative. NaN-free for r inside the limit.
distortion::Factor radial(const Lens& lens, double r) {
  const double r2 = r * r;
  const distortion::Factor f = lens.model() == LensModel::fisheye
                                   ? distortion::fisheye_factor(lens.coefficients(), r2)
                                   : distortion::polynomial_factor(lens.coefficients(), r2);
  return {r * f.value, f.value + 2.0 * r2 * f.by_r2};
}

// Whether the radial part still grows at this angle from the axis. The divisor must not have passed a pole.
bool grows(const Lens& lens, double angle) {
  const double r = std::tan(angle);
  if (lens.model() == LensModel::polynomial && !(distortion::divisor(lens.coefficients(), r * r) > 0.0)) return false;
  return radial(lens, r).by_r2 > 0.0;
}

// The radius whose radial image is `distorted`, or the limit where it is beyond: Newton kept inside a bracket.
double undistorted_radius(const Lens& lens, double distorted) {
  double low = 0.0;
  double high = std::sqrt(lens.max_radius2());
  if (radial(lens, high).value <= distorted) return high;
  double r = std::min(distorted, 0.5 * high);
  for (int step = 0; step < 100 && high - low > 1e-12 * high; ++step) {
    const auto [value, slope] = radial(lens, r);
    (value > distorted ? high : low) = r;
    const double next = r - (value - distorted) / slope;
    if (std::abs(next - r) < 1e-9 * (1.0 + r)) return next;
    r = next > low && next < high ? next : 0.5 * (low + high);
  }
  return r;
}

}  // namespace

Lens::Lens(LensModel model, const PinholeCamera& camera, std::span<const double> coefficients)
    : model_(model), count_(static_cast<int>(coefficients.size())), camera_(camera) {
  const auto finite = [](double v) { return std::isfinite(v); };
  if (!finite(camera.fx) || !finite(camera.fy) || !(camera.fx > 0.0) || !(camera.fy > 0.0)) {
    throw UsageError("focal length fx " + std::to_string(camera.fx) + ", fy " + std::to_string(camera.fy) +
                     ": must be positive pixels");
  }
  if (!finite(camera.cx) || !finite(camera.cy)) throw UsageError("principal point: must be finite pixels");
  const std::size_t n = coefficients.size();
  const bool known = model == LensModel::fisheye ? n == 0 || n == 4 : n == 0 || n == 4 || n == 5 || n == 8 || n == 12;
  if (!known) {
    throw UsageError(
        std::string(name(model)) + " lens with " + std::to_string(n) +
        " distortion coefficients (allowed: " + (model == LensModel::fisheye ? "0 or 4)" : "0, 4, 5, 8 or 12)"));
  }
  if (!std::all_of(coefficients.begin(), coefficients.end(), finite)) {
    throw UsageError("distortion coefficients: must be finite numbers");
  }
  std::copy(coefficients.begin(), coefficients.end(), k_.begin());
  find_limit();
}

bool Lens::distorts() const {
  return model_ == LensModel::fisheye || std::any_of(k_.begin(), k_.end(), [](double k) { return k != 0.0; });
}

void Lens::find_limit() {
  if (!distorts()) return;
  constexpr int steps = 2048;
  double inside = 0.0;
  double angle = steepest_angle;
  for (int i = 1; i <= steps; ++i) {
    double outside = steepest_angle * i / steps;
    if (grows(*this, outside)) {
      inside = outside;
      continue;
    }
    for (int halving = 0; halving < 40; ++halving) {
      const double middle = 0.5 * (inside + outside);
      (grows(*this, middle) ? inside : outside) = middle;
    }
    angle = inside;
    break;
  }
  max_radius2_ = std::tan(angle) * std::tan(angle);
}

Eigen::Vector2d Lens::pixel_from_ray(const Eigen::Vector2d& ray) const {
  if (!(ray.squaredNorm() <= max_radius2_)) return nowhere();
  const distortion::Point p = model_ == LensModel::fisheye ? distortion::fisheye(k_, ray.x(), ray.y())
                                                           : distortion::polynomial(k_, ray.x(), ray.y());
  return {camera_.fx * p.x + camera_.cx, camera_.fy * p.y + camera_.cy};
}

Eigen::Matrix2d Lens::pixel_from_ray_jacobian(const Eigen::Vector2d& ray) const {
  if (!(ray.squaredNorm() <= max_radius2_)) {
    return Eigen::Matrix2d::Constant(std::numeric_limits<double>::quiet_NaN());
  }
  Eigen::Matrix2d j = model_ == LensModel::fisheye ? distortion::fisheye_jacobian(k_, ray.x(), ray.y())
                                                   : distortion::polynomial_jacobian(k_, ray.x(), ray.y());
  j.row(0) *= camera_.fx;
  j.row(1) *= camera_.fy;
  return j;
}

Eigen::Vector2d Lens::ray_from_pixel(const Eigen::Vector2d& pixel) const {
  Eigen::Vector2d target((pixel.x() - camera_.cx) / camera_.fx, (pixel.y() - camera_.cy) / camera_.fy);
  const double distorted = target.norm();
  if (!std::isfinite(distorted)) return nowhere();
  if (!distorts() || distorted == 0.0) {
    if (!(target.squaredNorm() <= max_radius2_)) return nowhere();
    if (!distorts()) return target;
  }
  // The radial part first, which always converges, then both coordinates together for the rest.
  Eigen::Vector2d ray = target;
  if (distorted > 0.0) ray *= undistorted_radius(*this, distorted) / distorted;
  double best = std::numeric_limits<double>::infinity();
  Eigen::Vector2d best_ray = ray;
  const double limit = std::sqrt(max_radius2_);
  for (int step = 0; step < 30; ++step) {
    const double radius = ray.norm();
    if (radius > limit) ray *= limit / radius * (1.0 - 1e-12);
    const Eigen::Vector2d error = pixel_from_ray(ray) - pixel;
    const double size = error.cwiseAbs().maxCoeff();
    if (size < best) {
      best = size;
      best_ray = ray;
    } else if (best < 1e-10) {
      break;  // rounding is all that is left
    }
    const Eigen::Matrix2d j = pixel_from_ray_jacobian(ray);
    const double det = j.determinant();
    if (!(det > 0.0)) break;
    ray -= j.inverse() * error;
    if (!ray.allFinite()) break;
  }
  const double tolerance = 1e-10 * std::max(1.0, pixel.cwiseAbs().maxCoeff() * 1e-4);
  return best <= tolerance && pixel_from_ray_jacobian(best_ray).determinant() > 0.0 ? best_ray : nowhere();
}

}  // namespace vsfind
