#pragma once
/// @file
/// The lens formulas of lens.h as branch-free inline functions, so that one text serves single points and the
/// vectorized loops over many. Not for use outside this folder.

#include <Eigen/Core>
#include <array>
#include <cmath>

namespace vsfind::distortion {

using Coefficients = std::array<double, 12>;

/// A distorted ray, or the radial factor and its derivative by r².
struct Point {
  double x;
  double y;
};
struct Factor {
  double value;
  double by_r2;
};

/// Radial part only: k1 k2 p1 p2 k3.
inline double plain_factor(const Coefficients& k, double r2) { return 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4])); }
inline double divisor(const Coefficients& k, double r2) { return 1.0 + r2 * (k[5] + r2 * (k[6] + r2 * k[7])); }

inline Factor polynomial_factor(const Coefficients& k, double r2) {
  const double d = divisor(k, r2);
  const double f = plain_factor(k, r2) / d;
  const double n1 = k[0] + r2 * (2.0 * k[1] + r2 * 3.0 * k[4]);
  const double d1 = k[5] + r2 * (2.0 * k[6] + r2 * 3.0 * k[7]);
  return {f, (n1 - f * d1) / d};
}

/// The five coefficients that cv::calibrateCamera gives by default.
inline Point brown(const Coefficients& k, double x, double y) {
  const double r2 = x * x + y * y;
  const double f = plain_factor(k, r2) + 2.0 * (k[2] * y + k[3] * x);
  return {x * f + k[3] * r2, y * f + k[2] * r2};
}

/// All twelve.
inline Point polynomial(const Coefficients& k, double x, double y) {
  const double r2 = x * x + y * y;
  const double f = plain_factor(k, r2) / divisor(k, r2) + 2.0 * (k[2] * y + k[3] * x);
  return {x * f + r2 * (k[3] + k[8] + r2 * k[9]), y * f + r2 * (k[2] + k[10] + r2 * k[11])};
}

/// Arc tangent for x >= 0 without branches or calls, to 2e-16 (the reduction and rational approximation of the Cephes
/// library, S. L. Moshier).
inline double arc_tangent(double x) {
  const bool far = x > 2.414213562373095;
  const bool near = x <= 0.66;
  const double offset = far ? 1.5707963267948966 : near ? 0.0 : 0.7853981633974483;
  const double t = (far ? -1.0 : near ? x : x - 1.0) / (far ? x : near ? 1.0 : x + 1.0);
  const double z = t * t;
  const double p =
      (((-8.750608600031904122785E-1 * z - 1.615753718733365076637E1) * z - 7.500855792314704667340E1) * z -
       1.228866684490136173410E2) *
          z -
      6.485021904942025371773E1;
  const double q =
      ((((z + 2.485846490142306297962E1) * z + 1.650270098316988542046E2) * z + 4.328810604912902668951E2) * z +
       4.853903996359136964868E2) *
          z +
      1.945506571482613964425E2;
  return offset + (t + t * z * p / q);
}

inline double fisheye_angle(const Coefficients& k, double theta) {
  const double t2 = theta * theta;
  return theta * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
}
inline double fisheye_angle_slope(const Coefficients& k, double theta) {
  const double t2 = theta * theta;
  return 1.0 + t2 * (3.0 * k[0] + t2 * (5.0 * k[1] + t2 * (7.0 * k[2] + t2 * 9.0 * k[3])));
}

/// θ'/r; near the axis by its series, where the quotient is 0/0.
inline double fisheye_scale(const Coefficients& k, double r2) {
  const double r = std::sqrt(r2);
  const double series = 1.0 + r2 * (k[0] - 1.0 / 3.0 + r2 * (k[1] - k[0] + 0.2));
  const double quotient = fisheye_angle(k, arc_tangent(r)) / (r2 < 1e-6 ? 1.0 : r);
  return r2 < 1e-6 ? series : quotient;
}

inline Factor fisheye_factor(const Coefficients& k, double r2) {
  const double value = fisheye_scale(k, r2);
  if (r2 < 1e-6) return {value, k[0] - 1.0 / 3.0 + 2.0 * r2 * (k[1] - k[0] + 0.2)};
  const double slope = fisheye_angle_slope(k, arc_tangent(std::sqrt(r2))) / (1.0 + r2);  // dθ'/dr
  return {value, (slope - value) / (2.0 * r2)};
}

inline Point fisheye(const Coefficients& k, double x, double y) {
  const double f = fisheye_scale(k, x * x + y * y);
  return {x * f, y * f};
}

/// Derivative of `polynomial` by the ray.
inline Eigen::Matrix2d polynomial_jacobian(const Coefficients& k, double x, double y) {
  const double r2 = x * x + y * y;
  const Factor f = polynomial_factor(k, r2);
  const double prism_x = 2.0 * (k[8] + 2.0 * r2 * k[9]);
  const double prism_y = 2.0 * (k[10] + 2.0 * r2 * k[11]);
  const double mixed = 2.0 * (x * y * f.by_r2 + k[2] * x + k[3] * y);
  Eigen::Matrix2d j;
  j << f.value + 2.0 * x * x * f.by_r2 + 2.0 * k[2] * y + 6.0 * k[3] * x + prism_x * x, mixed + prism_x * y,
      mixed + prism_y * x, f.value + 2.0 * y * y * f.by_r2 + 6.0 * k[2] * y + 2.0 * k[3] * x + prism_y * y;
  return j;
}

/// Derivative of `fisheye` by the ray.
inline Eigen::Matrix2d fisheye_jacobian(const Coefficients& k, double x, double y) {
  const Factor f = fisheye_factor(k, x * x + y * y);
  Eigen::Matrix2d j;
  j << f.value + 2.0 * x * x * f.by_r2, 2.0 * x * y * f.by_r2, 2.0 * x * y * f.by_r2, f.value + 2.0 * y * y * f.by_r2;
  return j;
}

}  // namespace vsfind::distortion
