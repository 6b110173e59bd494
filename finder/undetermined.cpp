#include "finder/undetermined.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "finder/informative_points.h"
#include "finder/training_scene.h"

namespace vsfind {

namespace {

/// Part of the information that is left about some parameters once all others are fitted, too.
Eigen::MatrixXd left_for(const Eigen::MatrixXd& information, Eigen::Index first, Eigen::Index count) {
  const Eigen::Index n = information.rows();
  std::vector<Eigen::Index> rest;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (i < first || i >= first + count) rest.push_back(i);
  }
  const auto m = static_cast<Eigen::Index>(rest.size());
  Eigen::MatrixXd others(m, m);
  Eigen::MatrixXd shared(m, count);
  for (Eigen::Index i = 0; i < m; ++i) {
    for (Eigen::Index k = 0; k < m; ++k)
      others(i, k) = information(rest[static_cast<std::size_t>(i)], rest[static_cast<std::size_t>(k)]);
    for (Eigen::Index k = 0; k < count; ++k) shared(i, k) = information(rest[static_cast<std::size_t>(i)], first + k);
  }
  // What is undetermined itself takes nothing away.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(others);
  Eigen::MatrixXd left = information.block(first, first, count, count);
  const double least = 1e-6 * solver.eigenvalues().maxCoeff();
  for (Eigen::Index i = 0; i < m; ++i) {
    if (solver.eigenvalues()(i) <= least) continue;
    const Eigen::VectorXd along = shared.transpose() * solver.eigenvectors().col(i);
    left -= along * along.transpose() / solver.eigenvalues()(i);
  }
  return left;
}

}  // namespace

Undetermined undetermined_by(const std::vector<PatternPoint>& all, const Freedom& freedom, double noise_sigma) {
  Undetermined what;
  if (all.empty()) {
    what.directions = 2;
    return what;
  }
  // Distances from the middle, and in units of their spread: all values then count pixels.
  Eigen::Vector2d middle(0.0, 0.0);
  for (const PatternPoint& p : all) middle += Eigen::Vector2d(p.x, p.y) / static_cast<double>(all.size());
  double squares = 0.0;
  for (const PatternPoint& p : all) squares += (Eigen::Vector2d(p.x, p.y) - middle).squaredNorm();
  const double radius = std::max(1.0, std::sqrt(squares / static_cast<double>(all.size())));
  // Central differences of readings, whose noise is correlated over two pixels by exp(−2²/4σ²).
  constexpr double quantization = 0.3;  // grey levels: of a picture without any other noise
  // What a camera's noise hardly reaches is texture, which is structure.
  constexpr double most_noise = 12.0;
  const double noise =
      std::hypot(std::min(noise_sigma, most_noise), quantization) / (2.0 * std::sqrt(std::numbers::pi) * reading_sigma);
  const double gradient_noise =
      noise * noise * (1.0 - std::exp(-1.0 / (reading_sigma * reading_sigma))) / 2.0;  // variance

  Freedom asked = freedom;
  asked.blur = true;
  Eigen::MatrixXd information;
  for (const PatternPoint& p : all) {
    PatternPoint scaled = p;
    scaled.x = (p.x - middle.x()) / radius;
    scaled.y = (p.y - middle.y()) / radius;
    const Eigen::VectorXd j = pose_derivatives(scaled, asked);
    PatternPoint along_x = scaled;
    along_x.gradient_x = 1.0F;
    along_x.gradient_y = along_x.value = along_x.laplacian = 0.0F;
    PatternPoint along_y = along_x;
    along_y.gradient_x = 0.0F;
    along_y.gradient_y = 1.0F;
    Eigen::VectorXd by_x = pose_derivatives(along_x, asked);
    Eigen::VectorXd by_y = pose_derivatives(along_y, asked);
    by_x.tail(3).setZero();
    by_y.tail(3).setZero();
    if (information.size() == 0) information = Eigen::MatrixXd::Zero(j.size(), j.size());
    information += j * j.transpose() - gradient_noise * (by_x * by_x.transpose() + by_y * by_y.transpose());
  }
  // A value counts as determined where all points together settle it to a quarter of a pixel at a noise of 2 grey
  // levels, by more than chance (neighbours share their noise over about 4π·σ² pixels), and not a few hundred times
  // worse than the best-determined direction.
  constexpr double settled = 61.0;
  constexpr double by_chance = 4.0;
  constexpr double far_worse = 0.003;
  const double shared = 8.0 * std::numbers::pi * reading_sigma * reading_sigma;
  const double chance = gradient_noise * std::sqrt(shared * static_cast<double>(all.size()));
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> position(Eigen::MatrixXd(information.topLeftCorner(2, 2)));
  const double most = position.eigenvalues()(1);
  const double least = std::max(settled + by_chance * chance, far_worse * most);
  if (most < settled + by_chance * chance) {
    what.directions = 2;
    return what;
  }
  if (position.eigenvalues()(0) < least) {
    what.directions = 1;
    const Eigen::VectorXd along = position.eigenvectors().col(0);
    const double degrees = std::atan2(along(1), along(0)) * 180.0 / std::numbers::pi;
    what.direction_deg = std::fmod(degrees + 360.0, 180.0);
  }
  Eigen::Index at = 2;
  const auto lost = [&] { return left_for(information, at++, 1)(0, 0) < least; };
  if (freedom.angle) what.angle = lost();
  if (freedom.common_scale) {
    what.scale_x = lost();
  } else {
    if (freedom.scale_x) what.scale_x = lost();
    if (freedom.scale_y) what.scale_y = lost();
  }
  return what;
}

std::string direction_text(double degrees) {
  constexpr double nearly = 3.0;
  const double upright = std::abs(degrees - 90.0);
  if (upright < nearly) return "y";
  if (upright > 90.0 - nearly) return "x";
  return fmt::format("{:.0f} degrees (from +x toward +y)", degrees);
}

std::vector<std::string> warnings_of(const Undetermined& what, const Freedom& freedom) {
  std::vector<std::string> warnings;
  if (what.directions == 2) {
    warnings.emplace_back("the pattern shows no structure above the noise: its position can hardly be told");
  }
  if (what.directions == 1) {
    warnings.push_back(fmt::format("the pattern has no structure along {}: its position there cannot be told",
                                   direction_text(what.direction_deg)));
  }
  if (what.angle) warnings.emplace_back("the pattern looks the same turned by any angle: its angle cannot be told");
  if (what.scale_x) {
    warnings.push_back(fmt::format("the pattern looks the same at any {}: it cannot be told",
                                   freedom.common_scale ? "scale" : "scale_x"));
  }
  if (what.scale_y) warnings.emplace_back("the pattern looks the same at any scale_y: it cannot be told");
  return warnings;
}

}  // namespace vsfind
