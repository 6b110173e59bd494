#pragma once
/// @file
/// Small convex polygons in the plane: the outlines of patterns, and what two of them share.

#include <Eigen/Core>
#include <array>
#include <cstddef>

namespace vsfind {

/// Corners in the order of a walk along the border. Two outlines of four corners share one of eight at the most.
class Polygon {
 public:
  static constexpr std::size_t most_corners = 8;

  /// Not for more than most_corners: others are left out.
  void add(const Eigen::Vector2d& corner) {
    if (count_ < most_corners) corners_[count_++] = corner;
  }
  [[nodiscard]] std::size_t size() const { return count_; }
  [[nodiscard]] const Eigen::Vector2d& operator[](std::size_t i) const { return corners_[i]; }
  /// The corner after the last one is the first one.
  [[nodiscard]] const Eigen::Vector2d& after(std::size_t i) const { return corners_[(i + 1) % count_]; }

 private:
  std::array<Eigen::Vector2d, most_corners> corners_;
  std::size_t count_ = 0;
};

[[nodiscard]] double area(const Polygon& polygon);

/// Area that two convex polygons share that run the same way round, x to y.
[[nodiscard]] double shared_area(const Polygon& a, const Polygon& b);

}  // namespace vsfind
