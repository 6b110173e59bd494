#pragma once
/// @file
/// Where a pattern lies, and the words in which ranges of poses are asked for.
///
/// A pose maps the pattern as trained to where it is found, both in plane (calibrated) coordinates:
///     p = (x, y) + R(angle) · diag(scale_x, scale_y) · (q − origin),   R = [cos −sin; sin cos]
/// so a positive angle turns +x toward +y, clockwise on the screen in plain pixels.

#include <Eigen/Core>

namespace vsfind {

struct Pose {
  double x = 0.0;  ///< of the pattern's origin, plane units
  double y = 0.0;
  double angle_deg = 0.0;  ///< in (−180, 180]
  double scale_x = 1.0;
  double scale_y = 1.0;
};

/// The plane point of a pattern point given relative to the origin (plane units of training).
[[nodiscard]] Eigen::Vector2d plane_from_pattern(const Pose& pose, const Eigen::Vector2d& from_origin);

/// Between two directions, 0 … 180 degrees.
[[nodiscard]] double angle_between(double a_deg, double b_deg);
/// The order of poses that are equally good.
[[nodiscard]] bool precedes(const Pose& a, const Pose& b);

/// A closed interval; equal ends mean that the value is not searched.
struct Range {
  double min = 0.0;
  double max = 0.0;
  [[nodiscard]] bool searched() const { return max > min; }
  [[nodiscard]] double width() const { return max - min; }
};

/// A rectangle of whole pixels: covers x … x+width−1, y … y+height−1.
struct Roi {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
};

/// Whether bright stays bright.
enum class Polarity { same, reversed, any };
[[nodiscard]] constexpr const char* name(Polarity polarity) {
  return polarity == Polarity::same ? "same" : polarity == Polarity::reversed ? "reversed" : "any";
}

/// A signed correlation as it counts: higher is better.
template <typename Number>
[[nodiscard]] constexpr Number oriented(Number correlation, Polarity polarity) {
  if (polarity == Polarity::reversed || (polarity == Polarity::any && correlation < 0)) return -correlation;
  return correlation;
}

}  // namespace vsfind
