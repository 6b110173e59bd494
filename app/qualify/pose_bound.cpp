#include "app/qualify/pose_bound.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace vsfind {
namespace {

// Central difference of sixth order: right to 1% up to half the highest frequency.
constexpr std::array<double, 3> taps{3.0 / 4.0, -3.0 / 20.0, 1.0 / 60.0};
constexpr double taps_square_sum = 2.0 * (9.0 / 16.0 + 9.0 / 400.0 + 1.0 / 3600.0);
constexpr int reach = 3;

/// Whether the pattern covers a point (pattern pixels from the origin).
bool covers(const Pattern& pattern, const Eigen::Vector2d& q) {
  const PatternImage& image = pattern.image;
  if (image.width <= 0 || image.height <= 0 || image.mask.empty()) {
    return q.x() >= pattern.left && q.x() < pattern.left + pattern.width && q.y() >= pattern.top &&
           q.y() < pattern.top + pattern.height;
  }
  const double u = std::round(q.x() + image.origin_x);
  const double v = std::round(q.y() + image.origin_y);
  if (!(u >= 0.0 && v >= 0.0 && u < image.width && v < image.height)) return false;
  const auto index = static_cast<std::size_t>(v) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(u);
  return image.mask[index] == 255;
}

}  // namespace

void PoseBoundEstimator::add(const ImageView& image, const Mapping& mapping, const Pattern& pattern, const Pose& pose,
                             double noise) {
  if (image.empty() || !(noise > 0.0)) return;
  const double angle = pose.angle_deg * std::numbers::pi / 180.0;
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  // The box of the outline in the picture.
  Eigen::Vector2d low(1e9, 1e9);
  Eigen::Vector2d high(-1e9, -1e9);
  for (const double u : {0.0, 0.5, 1.0}) {
    for (const double v : {0.0, 0.5, 1.0}) {
      const Eigen::Vector2d q(pattern.left + u * pattern.width, pattern.top + v * pattern.height);
      const Eigen::Vector2d p = mapping.image_from_plane(plane_from_pattern(pose, pattern.pitch * q));
      if (!p.allFinite()) return;
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  }
  const int x0 = static_cast<int>(std::max<double>(reach, std::floor(low.x()) - 4.0));
  const int y0 = static_cast<int>(std::max<double>(reach, std::floor(low.y()) - 4.0));
  const int x1 = static_cast<int>(std::min<double>(image.width - 1 - reach, std::ceil(high.x()) + 4.0));
  const int y1 = static_cast<int>(std::min<double>(image.height - 1 - reach, std::ceil(high.y()) + 4.0));
  const double to_255 = 255.0 / image.white();
  Eigen::Matrix<double, 5, 5> sum = Eigen::Matrix<double, 5, 5>::Zero();
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const Eigen::Vector2d plane = mapping.plane_from_image(Eigen::Vector2d(x, y));
      const Eigen::Vector2d arm = plane - Eigen::Vector2d(pose.x, pose.y);
      const Eigen::Vector2d q((c * arm.x() + s * arm.y()) / (pose.scale_x * pattern.pitch),
                              (-s * arm.x() + c * arm.y()) / (pose.scale_y * pattern.pitch));
      if (!plane.allFinite() || !covers(pattern, q)) continue;
      Eigen::Vector2d gradient(0.0, 0.0);
      for (int k = 1; k <= reach; ++k) {
        const double tap = taps[static_cast<std::size_t>(k - 1)];
        gradient.x() += tap * (image.at(x + k, y) - image.at(x - k, y));
        gradient.y() += tap * (image.at(x, y + k) - image.at(x, y - k));
      }
      gradient *= to_255;
      Eigen::Matrix<double, 2, 3> moved;  // image steps for unit steps of the pose
      moved.leftCols<2>() = mapping.image_from_plane_jacobian(plane);
      moved.col(2) = moved.leftCols<2>() * Eigen::Vector2d(-arm.y(), arm.x());
      Eigen::Matrix<double, 5, 1> row;
      row.head<3>() = moved.transpose() * gradient;
      row[3] = image.at(x, y) * to_255;
      row[4] = 1.0;
      sum += row * row.transpose();
      sum.topLeftCorner<3, 3>() -= noise * noise * taps_square_sum * moved.transpose() * moved;
      sum(3, 3) -= noise * noise;
    }
  }
  information_ += sum / (noise * noise);
  ++pictures_;
}

PoseBound PoseBoundEstimator::bound(bool with_angle) const {
  if (pictures_ == 0) return {};
  Eigen::MatrixXd information = information_ / pictures_;
  if (!with_angle) {
    constexpr std::array<int, 4> kept{0, 1, 3, 4};
    Eigen::MatrixXd part(4, 4);
    for (int i = 0; i < 4; ++i) {
      for (int k = 0; k < 4; ++k)
        part(i, k) = information(kept[static_cast<std::size_t>(i)], kept[static_cast<std::size_t>(k)]);
    }
    information = part;
  }
  const Eigen::MatrixXd covariance = information.fullPivLu().inverse();
  PoseBound bound;
  if (!covariance.allFinite() || covariance.diagonal().minCoeff() <= 0.0) return bound;
  bound.x = std::sqrt(covariance(0, 0));
  bound.y = std::sqrt(covariance(1, 1));
  if (with_angle) bound.angle_deg = std::sqrt(covariance(2, 2)) * 180.0 / std::numbers::pi;
  return bound;
}

}  // namespace vsfind
