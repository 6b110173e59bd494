#include "calibration/corner_refine.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace vsfind {
namespace {

// Position, directions of the two edges' normals, blur; then what is linear: grey, its slope, contrast.
enum Parameter { at_x, at_y, normal_u, normal_v, blur, grey, slope_x, slope_y, contrast, parameter_count };
using Vector = Eigen::Matrix<double, parameter_count, 1>;
using Matrix = Eigen::Matrix<double, parameter_count, parameter_count>;

struct Sample {
  double x;  // frame pixels
  double y;
  double grey;
  double weight;
};

// A step from -1 to 1 blurred by sigma, and its derivatives.
struct Step {
  double value;
  double by_distance;
  double by_sigma;
};
Step blurred_step(double distance, double sigma) {
  const double slope =
      std::sqrt(2.0 / std::numbers::pi) / sigma * std::exp(-0.5 * distance * distance / (sigma * sigma));
  return {std::erf(distance / (std::numbers::sqrt2 * sigma)), slope, -distance / sigma * slope};
}

std::vector<Sample> window(const ImageView& image, Field field, const CornerGuess& guess) {
  std::vector<Sample> samples;
  const double r = guess.radius;
  const auto x0 = static_cast<int>(std::ceil(guess.position.x() - r));
  const auto x1 = static_cast<int>(std::floor(guess.position.x() + r));
  const int first = first_line(field);
  const int step = line_step(field);
  const auto row0 = static_cast<int>(std::ceil((guess.position.y() - r - first) / step));
  const auto row1 = static_cast<int>(std::floor((guess.position.y() + r - first) / step));
  if (x0 < 0 || x1 >= image.width || row0 < 0 || row1 >= image.height) return samples;
  for (int row = row0; row <= row1; ++row) {
    for (int x = x0; x <= x1; ++x) {
      const Eigen::Vector2d p(x, row * step + first);
      const double distance2 = (p - guess.position).squaredNorm() / (r * r);
      // Weights that fade keep bent edges and neighbouring corners from pulling.
      if (distance2 < 1.0) samples.push_back({p.x(), p.y(), static_cast<double>(image.at(x, row)), 1.0 - distance2});
    }
  }
  return samples;
}

double residual(const Vector& p, const Sample& s, Vector& slope) {
  const double dx = s.x - p[at_x];
  const double dy = s.y - p[at_y];
  const double cu = std::cos(p[normal_u]), su = std::sin(p[normal_u]);
  const double cv = std::cos(p[normal_v]), sv = std::sin(p[normal_v]);
  const Step u = blurred_step(cu * dx + su * dy, p[blur]);
  const Step v = blurred_step(cv * dx + sv * dy, p[blur]);
  const double by_u = p[contrast] * u.by_distance * v.value;
  const double by_v = p[contrast] * u.value * v.by_distance;
  slope[at_x] = -by_u * cu - by_v * cv - p[slope_x];
  slope[at_y] = -by_u * su - by_v * sv - p[slope_y];
  slope[normal_u] = by_u * (cu * dy - su * dx);
  slope[normal_v] = by_v * (cv * dy - sv * dx);
  slope[blur] = p[contrast] * (u.by_sigma * v.value + u.value * v.by_sigma);
  slope[grey] = 1.0;
  slope[slope_x] = dx;
  slope[slope_y] = dy;
  slope[contrast] = u.value * v.value;
  return p[grey] + p[slope_x] * dx + p[slope_y] * dy + p[contrast] * slope[contrast] - s.grey;
}

double normal_equations(const Vector& p, const std::vector<Sample>& samples, Matrix& normal, Vector& gradient) {
  normal.setZero();
  gradient.setZero();
  double cost = 0.0;
  Vector slope;
  for (const Sample& s : samples) {
    const double e = residual(p, s, slope);
    normal += s.weight * slope * slope.transpose();
    gradient += s.weight * e * slope;
    cost += s.weight * e * e;
  }
  return cost;
}

// Grey values for the guessed geometry, by linear least squares.
void fill_grey_values(Vector& p, const std::vector<Sample>& samples) {
  Matrix normal;
  Vector gradient;
  normal_equations(p, samples, normal, gradient);
  const Eigen::Matrix4d linear = normal.bottomRightCorner<4, 4>();
  p.tail<4>() -= linear.ldlt().solve(gradient.tail<4>());
}

}  // namespace

bool refine_corner(const ImageView& image, Field field, CornerGuess& guess) {
  const std::vector<Sample> samples = window(image, field, guess);
  if (samples.size() < std::size_t{2} * parameter_count) return false;
  Vector p = Vector::Zero();
  p[at_x] = guess.position.x();
  p[at_y] = guess.position.y();
  // The normal of an edge is its direction turned by a right angle.
  p[normal_u] = std::atan2(guess.along_row.x(), -guess.along_row.y());
  p[normal_v] = std::atan2(guess.along_column.x(), -guess.along_column.y());
  p[blur] = 0.8;
  fill_grey_values(p, samples);

  Matrix normal;
  Vector gradient;
  double cost = normal_equations(p, samples, normal, gradient);
  double damping = 1e-3;
  for (int step = 0; step < 60 && damping < 1e9; ++step) {
    Matrix damped = normal;
    damped.diagonal() *= 1.0 + damping;
    damped.diagonal().array() += 1e-12;
    Vector next = p - damped.ldlt().solve(gradient);
    next[blur] = std::clamp(next[blur], 0.25, 4.0);
    Matrix next_normal;
    Vector next_gradient;
    const double next_cost = normal_equations(next, samples, next_normal, next_gradient);
    if (!(next_cost < cost)) {
      damping *= 10.0;
      continue;
    }
    const double moved = (next - p).head<2>().norm();
    p = next;
    cost = next_cost;
    normal = next_normal;
    gradient = next_gradient;
    damping *= 0.1;
    if (moved < 1e-6) break;
  }
  const Eigen::Vector2d found = p.head<2>();
  const double contrast_floor = 0.02 * image.white();
  if (!found.allFinite() || !((found - guess.position).norm() < 0.5 * guess.radius)) return false;
  if (!(std::abs(p[contrast]) > contrast_floor)) return false;
  guess.position = found;
  return true;
}

}  // namespace vsfind
