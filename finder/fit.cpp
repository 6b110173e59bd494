#include "finder/fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace vsfind {

namespace {

constexpr int most_columns = 12;  // gain, offset, a, b, angle, scale_x, scale_y, blur, four of shading
constexpr double degrees = 180.0 / std::numbers::pi;

/// Which columns of the system are in use, and what they stand for.
struct Layout {
  int a = 2;
  int b = 3;
  int angle = -1;
  int scale_x = -1;
  int scale_y = -1;
  int blur = -1;
  int shading = -1;
  int first_nuisance = 4;  ///< from here on: neither gain nor offset nor pose
  int count = 4;

  explicit Layout(const Freedom& freedom) {
    if (freedom.angle) angle = count++;
    if (freedom.scale_x || freedom.common_scale) scale_x = count++;
    if (freedom.scale_y && !freedom.common_scale) scale_y = count++;
    first_nuisance = count;
    if (freedom.blur) blur = count++;
    if (freedom.shading) {
      shading = count;
      count += 4;
    }
  }
};

/// How much of the pattern's contrast a point may be off while the pose is still rough.
double rough_part(int iteration) { return iteration == 0 ? 0.6 : iteration == 1 ? 0.45 : 0.35; }

double median_of(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

void PoseFit::read_at(const PointArrays& points, const Projection& projection, const Reader& reader, const Pose& pose) {
  const auto n = static_cast<std::size_t>(points.size());
  u_.resize(n);
  v_.resize(n);
  image_.resize(n);
  inside_.resize(n);
  projection.level_from_pattern(pose, points.x.data(), points.y.data(), points.size(), u_.data(), v_.data());
  reader.read(u_.data(), v_.data(), points.size(), image_.data(), inside_.data());
}

double PoseFit::correlation(const PointArrays& points, const Projection& projection, const Reader& reader,
                            const Pose& pose, double& inside) {
  read_at(points, projection, reader, pose);
  double n = 0.0;
  double sum_i = 0.0;
  double sum_t = 0.0;
  double sum_ii = 0.0;
  double sum_tt = 0.0;
  double sum_it = 0.0;
  for (std::size_t k = 0; k < image_.size(); ++k) {
    const double w = inside_[k];
    const double i = image_[k];
    const double t = points.value[k];
    n += w;
    sum_i += w * i;
    sum_t += w * t;
    sum_ii += w * i * i;
    sum_tt += w * t * t;
    sum_it += w * i * t;
  }
  inside = image_.empty() ? 0.0 : n / static_cast<double>(image_.size());
  if (n < 4.0) return 0.0;
  const double variance_i = n * sum_ii - sum_i * sum_i;
  const double variance_t = n * sum_tt - sum_t * sum_t;
  constexpr double flat = 0.05;  // grey levels: below, there is nothing to correlate with
  if (variance_i < flat * n * n || variance_t < flat * n * n) return 0.0;
  return (n * sum_it - sum_i * sum_t) / std::sqrt(variance_i * variance_t);
}

PoseFit::Line PoseFit::agreeing_line(const PointArrays& points, std::size_t count, double contrast,
                                     Polarity polarity) const {
  Line best;
  double most = 0.0;
  constexpr std::size_t pairs = 40;
  constexpr std::size_t judges = 64;
  const std::size_t stride = std::max<std::size_t>(1, count / judges);
  std::size_t at = 0;
  for (std::size_t m = 0; m < pairs; ++m) {
    // Two points of clearly different value.
    const std::size_t i = (m * 37 + at) % count;
    std::size_t j = i;
    double difference = 0.0;
    for (std::size_t tries = 0; tries < 16 && std::abs(difference) < contrast; ++tries) {
      j = (j + 61 + tries * 7) % count;
      difference = points.value[j] - points.value[i];
      if (inside_[j] == 0.0) difference = 0.0;
    }
    at += 3;
    if (inside_[i] == 0.0 || std::abs(difference) < contrast) continue;
    const double gain = (image_[j] - image_[i]) / difference;
    if (std::abs(gain) < 0.03 || (polarity == Polarity::same && gain < 0.0) ||
        (polarity == Polarity::reversed && gain > 0.0)) {
      continue;
    }
    const double offset = image_[i] - gain * points.value[i];
    const double cut = 0.4 * std::abs(gain) * contrast;
    const double scale = 1.0 / (cut * cut);
    double agreeing = 0.0;
    for (std::size_t k = 0; k < count; k += stride) {
      const double e = image_[k] - gain * points.value[k] - offset;
      agreeing += inside_[k] * std::max(0.0, 1.0 - e * e * scale);
    }
    if (agreeing > most) {
      most = agreeing;
      best = {gain, offset};
    }
  }
  return best;
}

FitResult PoseFit::fit(const PointArrays& points, const Projection& projection, const Reader& reader,
                       const FitOptions& options, Pose& pose) {
  FitResult result;
  result.covariance.setZero();
  const Layout layout(options.freedom);
  const auto n = static_cast<std::size_t>(points.size());
  const int columns = layout.count;
  if (points.size() < columns) return result;
  const std::size_t trusted = options.trusted > 0 ? std::min(n, static_cast<std::size_t>(options.trusted)) : n;
  weight_.assign(n, 1.0);
  residual_.resize(n);
  columns_.resize(n * most_columns);
  // The values' mean is taken out: it keeps the system well conditioned.
  double mean = 0.0;
  double radius = 0.0;
  for (std::size_t k = 0; k < n; ++k) {
    mean += points.value[k];
    radius = std::max(radius, std::hypot(points.x[k], points.y[k]));
  }
  mean /= static_cast<double>(n);
  double contrast = 0.0;
  for (std::size_t k = 0; k < n; ++k) contrast += (points.value[k] - mean) * (points.value[k] - mean);
  contrast = std::sqrt(contrast / static_cast<double>(n));
  const double level_scale = projection.level_from_plane_jacobian({pose.x, pose.y}).cwiseAbs().maxCoeff() *
                             projection.pitch * std::max(pose.scale_x, pose.scale_y);

  Pose now = pose;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, most_columns, most_columns>;
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, most_columns, 1>;
  Matrix normal(columns, columns);
  Vector right(columns);
  Vector solution(columns);
  bool settled = false;
  for (int iteration = 0;; ++iteration) {
    read_at(points, projection, reader, now);
    const double skew_x = now.scale_y / now.scale_x;
    const double skew_y = now.scale_x / now.scale_y;
    for (std::size_t k = 0; k < n; ++k) {
      double* c = &columns_[k * most_columns];
      const double gx = points.gradient_x[k];
      const double gy = points.gradient_y[k];
      const double x = points.x[k];
      const double y = points.y[k];
      c[0] = points.value[k] - mean;
      c[1] = 1.0;
      c[2] = gx;
      c[3] = gy;
      if (layout.angle >= 0) c[layout.angle] = gy * skew_y * x - gx * skew_x * y;
      if (layout.scale_x >= 0) {
        c[layout.scale_x] = gx * x / now.scale_x;
        if (options.freedom.common_scale) c[layout.scale_x] += gy * y / now.scale_y;
      }
      if (layout.scale_y >= 0) c[layout.scale_y] = gy * y / now.scale_y;
      if (layout.blur >= 0) c[layout.blur] = points.laplacian[k];
      if (layout.shading >= 0) {
        c[layout.shading] = x / radius;
        c[layout.shading + 1] = y / radius;
        c[layout.shading + 2] = c[0] * x / radius;
        c[layout.shading + 3] = c[0] * y / radius;
      }
    }
    // At first a point may be wrong by much of the contrast, since the pose is; step by step it must agree better.
    const auto weigh = [&](double cut, bool outline) {
      for (std::size_t k = 0; k < n; ++k) {
        const double e = residual_[k] / cut;
        const double keep = std::max(0.0, 1.0 - e * e);
        weight_[k] = k < trusted || outline ? keep * keep : 0.0;
      }
    };
    if (iteration == 0 && options.robust) {
      const Line line = agreeing_line(points, trusted, contrast, options.polarity);
      if (line.gain == 0.0) return result;
      for (std::size_t k = 0; k < n; ++k) residual_[k] = image_[k] - line.gain * points.value[k] - line.offset;
      weigh(0.8 * std::abs(line.gain) * contrast, false);
    }
    const bool reweight = options.robust && iteration > 0;
    for (int round = 0; round < (reweight ? 2 : 1); ++round) {
      normal.setZero();
      right.setZero();
      double total = 0.0;
      for (std::size_t k = 0; k < n; ++k) {
        const double w = weight_[k] * inside_[k];
        if (w == 0.0) continue;
        total += w;
        const double* c = &columns_[k * most_columns];
        for (int r = 0; r < columns; ++r) {
          const double wr = w * c[r];
          for (int s = 0; s <= r; ++s) normal(r, s) += wr * c[s];
          right(r) += wr * image_[k];
        }
      }
      if (total < columns + 1) return result;
      Matrix damped = normal.template selfadjointView<Eigen::Lower>();
      for (int r = 0; r < columns; ++r) damped(r, r) += 1e-9 * damped(r, r) + 1e-12;
      solution = damped.ldlt().solve(right);
      if (!solution.allFinite()) return result;

      const double by_contrast = std::abs(solution(0)) * contrast * rough_part(iteration);
      scratch_.clear();
      for (std::size_t k = 0; k < n; ++k) {
        const double* c = &columns_[k * most_columns];
        double model = 0.0;
        for (int r = 0; r < columns; ++r) model += c[r] * solution(r);
        residual_[k] = image_[k] - model;
        // What disagrees grossly is hidden, and says nothing about the spread of the rest.
        const double off = std::abs(residual_[k]);
        if (inside_[k] > 0.0 && k < trusted && (!options.robust || off < by_contrast)) scratch_.push_back(off);
      }
      if (scratch_.size() <= static_cast<std::size_t>(columns)) return result;
      result.residual = 1.4826 * median_of(scratch_);
      if (!options.robust) continue;
      constexpr int rough = 2;
      const double by_spread = 4.685 * result.residual;
      const double least = 4.685 * options.noise_floor;
      const bool settling = options.settle && iteration >= rough;
      weigh(std::max(least, settling ? std::min(by_spread, by_contrast) : by_contrast), iteration > 0);
    }
    const double gain = solution(0);
    if (std::abs(gain) < 1e-3) return result;
    result.gain = gain;
    result.offset = solution(1) - gain * mean;
    if (settled || iteration >= options.iterations) break;
    // β = −g·dp, so dp = −β/g.
    const double a = -solution(layout.a) / gain;
    const double b = -solution(layout.b) / gain;
    const double turn = layout.angle >= 0 ? -solution(layout.angle) / gain : 0.0;
    const double grow_x = layout.scale_x >= 0 ? -solution(layout.scale_x) / gain : 0.0;
    const double grow_y = options.freedom.common_scale ? grow_x
                          : layout.scale_y >= 0        ? -solution(layout.scale_y) / gain
                                                       : 0.0;
    // No step may leave the neighbourhood in which the linear model means anything.
    const double reach = std::max({std::hypot(a * now.scale_x, b * now.scale_y), std::abs(turn) * radius,
                                   std::abs(grow_x) * radius, std::abs(grow_y) * radius}) *
                         level_scale;
    constexpr double longest = 2.0;  // level pixels
    const double part = reach > longest ? longest / reach : 1.0;
    const double angle = now.angle_deg / degrees;
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    const double du = projection.pitch * now.scale_x * a * part;
    const double dv = projection.pitch * now.scale_y * b * part;
    now.x += c * du - s * dv;
    now.y += s * du + c * dv;
    now.angle_deg += turn * part * degrees;
    now.scale_x += grow_x * part;
    now.scale_y += grow_y * part;
    if (!(now.scale_x > 0.05 && now.scale_y > 0.05 && now.scale_x < 20.0 && now.scale_y < 20.0)) return result;
    settled = reach < options.step_tolerance;
  }

  // How the pattern is seen at this pose: what is left of the picture after gain, offset, blur and shading, but not
  // after a change of the pose.
  constexpr double tolerated = 0.5;  // of the pattern's contrast, less for the nearer ones
  constexpr double visible = 0.35;
  const double seen_contrast = std::abs(result.gain) * contrast;
  const double visible_within = std::max(3.0 * result.residual, visible * seen_contrast);
  double weights = 0.0;
  double energy = 0.0;
  double left = 0.0;
  double sum = 0.0;
  double squares = 0.0;
  for (std::size_t k = 0; k < n; ++k) {
    if (inside_[k] == 0.0) continue;
    result.inside += 1.0 / static_cast<double>(n);
    const double* column = &columns_[k * most_columns];
    double model = 0.0;
    for (int r = 0; r < columns; ++r) {
      if (r < layout.a || r >= layout.first_nuisance) model += column[r] * solution(r);
    }
    const double off = image_[k] - model;
    if (std::abs(off) <= visible_within) result.visible += 1.0 / static_cast<double>(n);
    const double e = off / (tolerated * seen_contrast);
    if (std::abs(e) >= 1.0) continue;
    const double w = (1.0 - e * e) * (1.0 - e * e);
    weights += w;
    energy += w * column[0] * column[0];
    left += w * off * off;
    sum += w * image_[k];
    squares += w * image_[k] * image_[k];
  }
  const double spread = weights > 0.0 ? squares - sum * sum / weights : 0.0;
  if (spread > 0.0 && contrast > 0.0) {
    result.explained =
        std::sqrt(std::max(0.0, 1.0 - left / spread)) * energy / (static_cast<double>(n) * contrast * contrast);
  }
  const Matrix full = normal.template selfadjointView<Eigen::Lower>();
  const Matrix inverse = full.ldlt().solve(Matrix::Identity(columns, columns));
  const int at[5] = {layout.a, layout.b, layout.angle, layout.scale_x,
                     options.freedom.common_scale ? layout.scale_x : layout.scale_y};
  for (int r = 0; r < 5; ++r) {
    for (int s = 0; s < 5; ++s) {
      if (at[r] >= 0 && at[s] >= 0) result.covariance(r, s) = inverse(at[r], at[s]) / (result.gain * result.gain);
    }
  }
  result.ok = inverse.allFinite();
  now.angle_deg = std::remainder(now.angle_deg, 360.0);
  pose = now;
  return result;
}

}  // namespace vsfind
