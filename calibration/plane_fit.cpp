#include "calibration/plane_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "acquisition/errors.h"
#include "calibration/rotation.h"

namespace vsfind {
namespace {

using Vector9d = Eigen::Matrix<double, 9, 1>;
// Of a size known at run time only: unrolled solvers take long to compile and are no faster here.
using Matrix = Eigen::MatrixXd;
using Vector6d = Eigen::Matrix<double, 6, 1>;

// Takes the points to mean 0 and mean distance √2.
Eigen::Matrix3d normalization(std::span<const Eigen::Vector2d> points) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const auto& p : points) mean += p;
  mean /= static_cast<double>(points.size());
  double distance = 0.0;
  for (const auto& p : points) distance += (p - mean).norm();
  distance /= static_cast<double>(points.size());
  if (!(distance > 0.0) || !std::isfinite(distance)) throw UsageError("the points all lie in one place");
  const double scale = std::numbers::sqrt2 / distance;
  Eigen::Matrix3d t = Eigen::Matrix3d::Identity();
  t.topLeftCorner<2, 2>() *= scale;
  t.topRightCorner<2, 1>() = -scale * mean;
  return t;
}

std::vector<Eigen::Vector2d> transformed(const Eigen::Matrix3d& t, std::span<const Eigen::Vector2d> points) {
  std::vector<Eigen::Vector2d> result;
  result.reserve(points.size());
  for (const auto& p : points) result.emplace_back(t.topLeftCorner<2, 2>() * p + t.topRightCorner<2, 1>());
  return result;
}

Vector9d linear_homography(const std::vector<Eigen::Vector2d>& plane, const std::vector<Eigen::Vector2d>& out) {
  Matrix normal = Matrix::Zero(9, 9);
  for (std::size_t i = 0; i < plane.size(); ++i) {
    const Eigen::Vector3d p = plane[i].homogeneous();
    Vector9d row;
    row << p, Eigen::Vector3d::Zero(), -out[i].x() * p;
    normal += row * row.transpose();
    row << Eigen::Vector3d::Zero(), p, -out[i].y() * p;
    normal += row * row.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(normal);
  if (!(solver.eigenvalues()(1) > 1e-12 * solver.eigenvalues()(8))) {
    throw UsageError("the points do not determine the plane: too many of them lie on one line");
  }
  return solver.eigenvectors().col(0);
}

// Sum of squared distances; infinite where a point is not in front.
double homography_cost(const Vector9d& h, const std::vector<Eigen::Vector2d>& plane,
                       const std::vector<Eigen::Vector2d>& out) {
  double cost = 0.0;
  for (std::size_t i = 0; i < plane.size(); ++i) {
    const Eigen::Vector3d p = plane[i].homogeneous();
    const double w = h.tail<3>().dot(p);
    if (!(w > 0.0)) return std::numeric_limits<double>::infinity();
    cost += (Eigen::Vector2d(h.head<3>().dot(p), h.segment<3>(3).dot(p)) / w - out[i]).squaredNorm();
  }
  return cost;
}

// Gauss-Newton on the sphere |h| = 1.
Vector9d polished(Vector9d h, const std::vector<Eigen::Vector2d>& plane, const std::vector<Eigen::Vector2d>& out) {
  double cost = homography_cost(h, plane, out);
  for (int step = 0; step < 20; ++step) {
    Matrix normal = h * h.transpose();
    Vector9d gradient = Vector9d::Zero();
    for (std::size_t i = 0; i < plane.size(); ++i) {
      const Eigen::Vector3d p = plane[i].homogeneous();
      const double w = h.tail<3>().dot(p);
      const double x = h.head<3>().dot(p) / w;
      const double y = h.segment<3>(3).dot(p) / w;
      Vector9d row_x, row_y;
      row_x << p / w, Eigen::Vector3d::Zero(), -x / w * p;
      row_y << Eigen::Vector3d::Zero(), p / w, -y / w * p;
      normal += row_x * row_x.transpose() + row_y * row_y.transpose();
      gradient += row_x * (x - out[i].x()) + row_y * (y - out[i].y());
    }
    const Vector9d next = (h - normal.ldlt().solve(gradient)).normalized();
    const double next_cost = homography_cost(next, plane, out);
    if (!(next_cost < cost)) break;
    h = next;
    cost = next_cost;
  }
  return h;
}

struct PoseFit {
  PlanePose pose;
  double cost = std::numeric_limits<double>::infinity();
};

double pose_cost(const Lens& lens, const PlanePose& pose, std::span<const Eigen::Vector2d> plane,
                 std::span<const Eigen::Vector2d> frame) {
  double cost = 0.0;
  for (std::size_t i = 0; i < plane.size(); ++i) {
    const Eigen::Vector3d p = pose.rotation.leftCols<2>() * plane[i] + pose.translation;
    if (!(p.z() > 0.0)) return std::numeric_limits<double>::infinity();
    const double distance2 = (lens.pixel_from_ray(p.head<2>() / p.z()) - frame[i]).squaredNorm();
    if (std::isnan(distance2)) return std::numeric_limits<double>::infinity();
    cost += distance2;
  }
  return cost;
}

// Levenberg-Marquardt over a small turn (from the left) and a shift.
PoseFit refined_pose(const Lens& lens, const PlanePose& pose, std::span<const Eigen::Vector2d> plane,
                     std::span<const Eigen::Vector2d> frame) {
  PoseFit best{pose, pose_cost(lens, pose, plane, frame)};
  double damping = 1e-4;
  for (int step = 0; step < 100 && std::isfinite(best.cost) && damping < 1e12; ++step) {
    Matrix normal = Matrix::Zero(6, 6);
    Vector6d gradient = Vector6d::Zero();
    for (std::size_t i = 0; i < plane.size(); ++i) {
      const Eigen::Vector3d turned = best.pose.rotation.leftCols<2>() * plane[i];
      const Eigen::Vector3d p = turned + best.pose.translation;
      const Eigen::Vector2d ray = p.head<2>() / p.z();
      Eigen::Matrix<double, 2, 3> by_point;
      by_point << 1.0 / p.z(), 0.0, -ray.x() / p.z(), 0.0, 1.0 / p.z(), -ray.y() / p.z();
      Eigen::Matrix3d cross;
      cross << 0.0, -turned.z(), turned.y(), turned.z(), 0.0, -turned.x(), -turned.y(), turned.x(), 0.0;
      Eigen::Matrix<double, 2, 6> row;
      row << by_point * -cross, by_point;
      row = (lens.pixel_from_ray_jacobian(ray) * row).eval();
      normal += row.transpose() * row;
      gradient += row.transpose() * (lens.pixel_from_ray(ray) - frame[i]);
    }
    Matrix damped = normal;
    damped.diagonal() *= 1.0 + damping;
    const Vector6d change = -damped.ldlt().solve(gradient);
    PlanePose next;
    next.rotation = rotation_from_vector(change.head<3>()) * best.pose.rotation;
    next.translation = best.pose.translation + change.tail<3>();
    const double cost = pose_cost(lens, next, plane, frame);
    if (cost < best.cost) {
      const bool done = best.cost - cost <= 1e-14 * best.cost;
      best = {next, cost};
      damping *= 0.1;
      if (done) break;
    } else {
      damping *= 10.0;
    }
  }
  return best;
}

PlanePose pose_of_homography(const Eigen::Matrix3d& ray_from_plane) {
  const Eigen::Matrix3d h = ray_from_plane * (2.0 / (ray_from_plane.col(0).norm() + ray_from_plane.col(1).norm()));
  Eigen::Matrix3d r;
  r << h.col(0), h.col(1), h.col(0).cross(h.col(1));
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(r, Eigen::ComputeFullU | Eigen::ComputeFullV);
  PlanePose pose;
  pose.rotation = svd.matrixU() * svd.matrixV().transpose();
  pose.translation = h.col(2);
  return pose;
}

// From far away a plane tilted one way looks much like the same plane tilted the other way.
PlanePose other_tilt(const PlanePose& pose) {
  const Eigen::Vector3d sight = pose.translation.normalized();
  PlanePose other = pose;
  other.rotation = Eigen::AngleAxisd(std::numbers::pi, sight).toRotationMatrix() * pose.rotation *
                   Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return other;
}

}  // namespace

Eigen::Matrix3d fit_homography(std::span<const Eigen::Vector2d> plane, std::span<const Eigen::Vector2d> out) {
  if (plane.size() != out.size() || plane.size() < 4) throw UsageError("a plane needs at least four points");
  const Eigen::Matrix3d plane_norm = normalization(plane);
  const Eigen::Matrix3d out_norm = normalization(out);
  const auto p = transformed(plane_norm, plane);
  const auto q = transformed(out_norm, out);
  Vector9d h = linear_homography(p, q);
  double in_front = 0.0;
  for (const auto& point : p) in_front += h.tail<3>().dot(point.homogeneous()) > 0.0 ? 1.0 : -1.0;
  if (in_front < 0.0) h = -h;
  if (std::isinf(homography_cost(h, p, q))) {
    throw UsageError(
        "no camera sees a plane like this: some points would lie behind the horizon (are two points swapped?)");
  }
  h = polished(h, p, q);
  Eigen::Matrix3d rows;
  rows << h(0), h(1), h(2), h(3), h(4), h(5), h(6), h(7), h(8);
  const Eigen::Matrix3d result = out_norm.inverse() * rows * plane_norm;
  return result / result.norm();
}

PlanePose fit_plane_pose(const Lens& lens, std::span<const Eigen::Vector2d> plane,
                         std::span<const Eigen::Vector2d> frame) {
  std::vector<Eigen::Vector2d> rays;
  for (const auto& pixel : frame) {
    rays.push_back(lens.ray_from_pixel(pixel));
    if (!rays.back().allFinite()) {
      throw UsageError("the lens model does not reach the image point " + std::to_string(pixel.x()) + ", " +
                       std::to_string(pixel.y()));
    }
  }
  const PlanePose start = pose_of_homography(fit_homography(plane, rays));
  const PoseFit first = refined_pose(lens, start, plane, frame);
  // About the middle of the points, where both tilts look alike.
  PlanePose centred = first.pose;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const auto& p : plane) middle += p;
  middle /= static_cast<double>(plane.size());
  centred.translation += centred.rotation.leftCols<2>() * middle;
  PlanePose other = other_tilt(centred);
  other.translation -= other.rotation.leftCols<2>() * middle;
  const PoseFit second = refined_pose(lens, other, plane, frame);
  const PoseFit& best = second.cost < first.cost ? second : first;
  if (std::isinf(best.cost)) throw UsageError("no pose of the plane explains the points");
  return best.pose;
}

}  // namespace vsfind
