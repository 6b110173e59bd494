#include "app/qualify/fiducials.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "app/qualify/edge_line.h"

namespace vsfind {
namespace {

/// The square of this picture that is the old one moved, roughly.
std::optional<RoughSquare> follow(const ImageView& image, const Mapping& mapping, const RoughSquare& old) {
  Eigen::Vector2d low = old.corners[0];
  Eigen::Vector2d high = old.corners[0];
  for (const auto& corner : old.corners) {
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
  }
  const Eigen::Vector2d margin = 0.55 * (high - low) + Eigen::Vector2d(6.0, 6.0);
  const Roi where{static_cast<int>(std::floor(low.x() - margin.x())),
                  static_cast<int>(std::floor(low.y() - margin.y())),
                  static_cast<int>(std::ceil(high.x() - low.x() + 2.0 * margin.x())),
                  static_cast<int>(std::ceil(high.y() - low.y() + 2.0 * margin.y()))};
  std::optional<RoughSquare> nearest;
  for (const auto& square : find_squares(image, mapping, where)) {
    if (std::abs(square.side - old.side) > 0.15 * old.side) continue;
    if (!nearest || (square.centre - old.centre).norm() < (nearest->centre - old.centre).norm()) nearest = square;
  }
  return nearest;
}

}  // namespace

std::optional<MeasuredSquare> measure_square(const ImageView& image, const Mapping& mapping, const RoughSquare& rough) {
  constexpr double reach = 6.0;  // pixels to either side of the edge
  const double least_step = 0.05 * image.white();
  std::array<EdgeLine, 4> sides;
  double variance = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d& a = rough.corners[i];
    const Eigen::Vector2d& b = rough.corners[(i + 1) % 4];
    const auto line = fit_edge_line(image, mapping, a, b, std::min(reach, 0.2 * (b - a).norm()), least_step);
    if (!line) return std::nullopt;
    sides[i] = *line;
    variance += line->sigma_offset * line->sigma_offset;
  }
  MeasuredSquare square;
  square.centre.setZero();
  for (std::size_t i = 0; i < 4; ++i) {
    const auto corner = intersection(sides[(i + 3) % 4], sides[i]);
    // A fit that has gone to another edge is no corner of this square.
    if (!corner || (mapping.image_from_plane(*corner) - rough.corners[i]).norm() > 2.0 * reach) return std::nullopt;
    square.corners.push_back(*corner);
    square.centre += *corner / 4.0;
  }
  // Along either axis the centre is the mean of two opposite sides.
  square.sigma = std::sqrt(variance / 8.0);
  return square;
}

std::optional<FiducialPose> FiducialTracker::measure(const ImageView& image, const Mapping& mapping) {
  if (last_.empty()) return std::nullopt;
  std::vector<RoughSquare> now;
  std::vector<Eigen::Vector2d> centres;
  FiducialPose pose;
  pose.centre.setZero();
  double variance = 0.0;
  for (const auto& old : last_) {
    const auto rough = follow(image, mapping, old);
    if (!rough) return std::nullopt;
    const auto square = measure_square(image, mapping, *rough);
    if (!square) return std::nullopt;
    now.push_back(*rough);
    centres.push_back(square->centre);
    pose.centre += square->centre;
    variance += square->sigma * square->sigma;
  }
  const auto count = static_cast<double>(centres.size());
  pose.centre /= count;
  pose.sigma = std::sqrt(variance) / count;
  for (auto& centre : centres) centre -= pose.centre;
  if (first_.empty()) first_ = centres;
  // The rotation that takes the first picture's centres to these best (Horn 1987, in the plane).
  double dot = 0.0;
  double cross = 0.0;
  double spread = 0.0;
  for (std::size_t i = 0; i < centres.size(); ++i) {
    dot += first_[i].dot(centres[i]);
    cross += first_[i].x() * centres[i].y() - first_[i].y() * centres[i].x();
    spread += centres[i].squaredNorm();
  }
  constexpr double degrees = 180.0 / std::numbers::pi;
  pose.angle_deg = spread > 0.0 ? std::atan2(cross, dot) * degrees : 0.0;
  pose.sigma_angle_deg = spread > 0.0 ? std::sqrt(variance / count / spread) * degrees : 0.0;
  last_ = std::move(now);
  return pose;
}

}  // namespace vsfind
