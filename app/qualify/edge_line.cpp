#include "app/qualify/edge_line.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace vsfind {
namespace {

constexpr double left_out = 0.15;  // of the segment, at either end: corners are round

/// A pixel in the line's own frame: t along it (−1 … 1), v across, plane units.
struct Sample {
  double t;
  double v;
  double grey;
};

/// The parameters, in this order: turn and offset of the line, blur, low, its change along, step, its change along.
using Parameters = Eigen::Matrix<double, 7, 1>;
using Normal = Eigen::Matrix<double, 7, 7>;

/// Sum of squares; fills the normal equations where wanted. `half` is half the segment, plane units.
double residuals(const std::vector<Sample>& samples, double half, const Parameters& p, Normal* normal,
                 Parameters* gradient) {
  if (normal != nullptr) normal->setZero();
  if (gradient != nullptr) gradient->setZero();
  const double cosine = std::cos(p[0]);
  const double sine = std::sin(p[0]);
  double sum = 0.0;
  for (const Sample& s : samples) {
    const double along = s.t * half;
    const double d = s.v * cosine - along * sine - p[1];
    const double q = d / p[2];
    const double phi = 0.5 * std::erfc(-q / std::numbers::sqrt2);
    const double step = p[5] + p[6] * s.t;
    const double r = s.grey - (p[3] + p[4] * s.t + step * phi);
    sum += r * r;
    if (normal == nullptr) continue;
    const double slope = step * std::exp(-0.5 * q * q) / (std::sqrt(2.0 * std::numbers::pi) * p[2]);
    Parameters row;
    row << slope * (-s.v * sine - along * cosine), -slope, -slope * q, 1.0, s.t, phi, s.t * phi;
    normal->noalias() += row * row.transpose();
    *gradient += row * r;
  }
  return sum;
}

/// Levenberg and Marquardt. False where it runs away.
bool fit(const std::vector<Sample>& samples, double half, double pixel, Parameters& p, double& sum, Normal& normal) {
  Parameters gradient;
  sum = residuals(samples, half, p, &normal, &gradient);
  double lambda = 1e-3;
  for (int iteration = 0; iteration < 60; ++iteration) {
    Normal damped = normal;
    damped.diagonal() *= 1.0 + lambda;
    const Parameters step = damped.ldlt().solve(gradient);
    if (!step.allFinite()) return false;
    Parameters tried = p + step;
    tried[2] = std::clamp(tried[2], 0.15 * pixel, 8.0 * pixel);
    const double error = residuals(samples, half, tried, nullptr, nullptr);
    if (error <= sum) {
      const bool still = std::abs(step[1]) < 1e-7 * pixel && std::abs(step[0]) * half < 1e-7 * pixel;
      p = tried;
      sum = residuals(samples, half, p, &normal, &gradient);
      if (still) return true;
      lambda = std::max(1e-9, lambda / 10.0);
    } else {
      lambda *= 10.0;
      if (lambda > 1e8) return true;  // no step makes it better: at the minimum to rounding
    }
  }
  return true;
}

}  // namespace

std::optional<EdgeLine> fit_edge_line(const ImageView& image, const Mapping& mapping, const Eigen::Vector2d& a,
                                      const Eigen::Vector2d& b, double reach, double least_step) {
  const double length = (b - a).norm();
  if (image.empty() || !std::isfinite(length) || length < 4.0 || !(reach >= 1.0)) return std::nullopt;
  Eigen::Vector2d from = a;
  Eigen::Vector2d to = b;
  EdgeLine line;
  // The second round takes the pixels about the line that the first one found.
  for (int round = 0; round < 2; ++round) {
    const Eigen::Vector2d along = (to - from) / (to - from).norm();
    const Eigen::Vector2d across(-along.y(), along.x());
    const Eigen::Vector2d middle = 0.5 * (from + to);
    const Eigen::Vector2d plane_a = mapping.plane_from_image(from);
    const Eigen::Vector2d plane_b = mapping.plane_from_image(to);
    const Eigen::Vector2d centre = mapping.plane_from_image(middle);
    const double half = 0.5 * (plane_b - plane_a).norm();
    if (!(half > 0.0) || !centre.allFinite()) return std::nullopt;
    const Eigen::Vector2d u = (plane_b - plane_a) / (2.0 * half);
    const Eigen::Vector2d n(-u.y(), u.x());
    const double pixel = (mapping.plane_from_image(middle + across) - centre).norm();
    const double side = n.dot(mapping.plane_from_image(middle + across) - centre) >= 0.0 ? 1.0 : -1.0;

    std::vector<Sample> samples;
    double low = 0.0;
    double high = 0.0;
    int lows = 0;
    int highs = 0;
    const double half_length = (0.5 - left_out) * length;
    const double box = half_length + reach + 1.0;
    const int x0 = std::max(0, static_cast<int>(std::floor(middle.x() - box)));
    const int x1 = std::min(image.width - 1, static_cast<int>(std::ceil(middle.x() + box)));
    const int y0 = std::max(0, static_cast<int>(std::floor(middle.y() - box)));
    const int y1 = std::min(image.height - 1, static_cast<int>(std::ceil(middle.y() + box)));
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        const Eigen::Vector2d from_middle = Eigen::Vector2d(x, y) - middle;
        const double v = across.dot(from_middle);
        if (std::abs(along.dot(from_middle)) > half_length || std::abs(v) > reach) continue;
        const Eigen::Vector2d p = mapping.plane_from_image(Eigen::Vector2d(x, y)) - centre;
        if (!p.allFinite()) continue;
        const double grey = image.at(x, y);
        samples.push_back({u.dot(p) / half, n.dot(p), grey});
        if (side * v < -0.5 * reach) {
          low += grey;
          ++lows;
        } else if (side * v > 0.5 * reach) {
          high += grey;
          ++highs;
        }
      }
    }
    if (samples.size() < 20 || lows < 3 || highs < 3) return std::nullopt;
    low /= lows;
    high /= highs;
    if (std::abs(high - low) < least_step) return std::nullopt;
    Parameters p;
    p << 0.0, 0.0, round == 0 ? pixel : line.blur, low, 0.0, high - low, 0.0;
    double sum = 0.0;
    Normal normal;
    if (!fit(samples, half, pixel, p, sum, normal)) return std::nullopt;
    if (std::abs(p[1]) > reach * pixel || std::abs(p[0]) > 0.2 || std::abs(p[5]) < least_step) return std::nullopt;

    line.direction = std::cos(p[0]) * u + std::sin(p[0]) * n;
    line.point = centre + p[1] * (std::cos(p[0]) * n - std::sin(p[0]) * u);
    line.blur = p[2];
    line.step = p[5];
    const double variance = sum / static_cast<double>(samples.size() - 7);
    line.noise = std::sqrt(variance);
    line.sigma_offset = std::sqrt(std::max(0.0, variance * normal.ldlt().solve(Parameters::Unit(1))[1]));
    if (!line.point.allFinite() || !std::isfinite(line.sigma_offset)) return std::nullopt;
    from = mapping.image_from_plane(line.point - half * line.direction);
    to = mapping.image_from_plane(line.point + half * line.direction);
    if (!from.allFinite() || !to.allFinite()) return std::nullopt;
  }
  return line;
}

std::optional<Eigen::Vector2d> intersection(const EdgeLine& a, const EdgeLine& b) {
  const double cross = a.direction.x() * b.direction.y() - a.direction.y() * b.direction.x();
  if (std::abs(cross) < 1e-6) return std::nullopt;
  const Eigen::Vector2d between = b.point - a.point;
  const double t = (between.x() * b.direction.y() - between.y() * b.direction.x()) / cross;
  return a.point + t * a.direction;
}

}  // namespace vsfind
