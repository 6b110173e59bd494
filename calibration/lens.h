#pragma once
/// @file
/// A camera's lens: from a viewing ray to a frame pixel and back. Immutable; safe to share between threads.
///
/// Frames: a ray is (x, y) = (X/Z, Y/Z) in camera coordinates, X right, Y down, Z forward. A pixel is in frame
/// coordinates (an integer is a pixel centre).
///
/// Models (the coefficients' order and meaning are OpenCV's, cv::calibrateCamera and cv::fisheye::calibrate):
///  - polynomial: k1 k2 p1 p2 [k3 [k4 k5 k6 [s1 s2 s3 s4]]]. With r² = x² + y²,
///      F  = (1 + k1 r² + k2 r⁴ + k3 r⁶) / (1 + k4 r² + k5 r⁴ + k6 r⁶)
///      x' = x F + 2 p1 x y + p2 (r² + 2 x²) + s1 r² + s2 r⁴
///      y' = y F + p1 (r² + 2 y²) + 2 p2 x y + s3 r² + s4 r⁴
///    (Brown 1966; the rational form Claus & Fitzgibbon 2005.)
///  - fisheye (equidistant): k1 k2 k3 k4. With θ = atan r, θ' = θ (1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸), (x', y') = (x,
///  y) θ'/r.
///    (Kannala & Brandt 2006.)
/// Then pixel = (fx x' + cx, fy y' + cy).
///
/// Such a polynomial turns back beyond some radius, where it would bring rays from far outside into the picture. The
/// lens ends there: rays further out, and pixels that no ray inside reaches, give NaN in both coordinates, never a
/// wrong number.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

namespace vsfind {

enum class LensModel : std::uint8_t { polynomial, fisheye };
/// "polynomial" or "fisheye", as in the calibration file.
[[nodiscard]] constexpr const char* name(LensModel model) {
  return model == LensModel::polynomial ? "polynomial" : "fisheye";
}

/// Focal lengths and principal point, frame pixels.
struct PinholeCamera {
  double fx = 1.0;
  double fy = 1.0;
  double cx = 0.0;
  double cy = 0.0;
  [[nodiscard]] bool operator==(const PinholeCamera& other) const = default;
};

class Lens {
 public:
  static constexpr int max_coefficients = 12;

  /// A pinhole without distortion.
  Lens() = default;
  /// Throws UsageError where a number is not finite, a focal length not positive, or the count of coefficients fits no
  /// form of the model (polynomial 0, 4, 5, 8 or 12; fisheye 0 or 4; trailing zeros may be left in or out).
  Lens(LensModel model, const PinholeCamera& camera, std::span<const double> coefficients);

  [[nodiscard]] LensModel model() const { return model_; }
  [[nodiscard]] const PinholeCamera& camera() const { return camera_; }
  /// All twelve, absent ones zero.
  [[nodiscard]] const std::array<double, max_coefficients>& coefficients() const { return k_; }
  /// How many the lens was made with.
  [[nodiscard]] int coefficient_count() const { return count_; }
  /// Whether any coefficient (or the fisheye itself) bends straight lines.
  [[nodiscard]] bool distorts() const;
  /// The rays that the model holds for: x² + y² at most this.
  [[nodiscard]] double max_radius2() const { return max_radius2_; }

  [[nodiscard]] Eigen::Vector2d pixel_from_ray(const Eigen::Vector2d& ray) const;
  /// Solved by Newton's method to 1e-10 pixels or better; NaN where the model reaches no such pixel.
  [[nodiscard]] Eigen::Vector2d ray_from_pixel(const Eigen::Vector2d& pixel) const;
  /// Derivative of pixel_from_ray.
  [[nodiscard]] Eigen::Matrix2d pixel_from_ray_jacobian(const Eigen::Vector2d& ray) const;
  [[nodiscard]] bool operator==(const Lens& other) const = default;

 private:
  void find_limit();

  LensModel model_ = LensModel::polynomial;
  int count_ = 0;
  PinholeCamera camera_;
  std::array<double, max_coefficients> k_{};
  double max_radius2_ = 1e12;
};

}  // namespace vsfind
