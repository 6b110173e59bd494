#include "finder/fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "finder/fit_kernels.h"

namespace vsfind {

namespace {

constexpr int most_columns =
    kernels::most_columns - 1;  // gain, offset, a, b, angle, two scales, three of blur, four of shading
constexpr double degrees = 180.0 / std::numbers::pi;

/// Which columns of the system are in use, and what they stand for. Angle and scales are in pattern pixels at the
/// farthest point, so that all columns are of like size.
struct Layout {
  int a = 2;
  int b = 3;
  int angle = -1;
  int scale_x = -1;
  int scale_y = -1;
  int first_nuisance = 4;  ///< from here on: neither gain nor offset nor pose
  int count = 4;
  std::array<const float*, kernels::most_columns> columns{};

  Layout(const Freedom& freedom, const PointArrays& points)
      : columns{points.value.data(), points.one.data(), points.gradient_x.data(), points.gradient_y.data()} {
    if (freedom.angle) angle = add(nullptr);
    if (freedom.scale_x || freedom.common_scale) scale_x = add(points.gx_x.data());
    if (freedom.scale_y && !freedom.common_scale) scale_y = add(points.gy_y.data());
    first_nuisance = count;
    if (freedom.blur) add(points.laplacian.data());
    if (freedom.directional_blur) {
      add(points.stretch.data());
      add(points.shear.data());
    }
    if (freedom.shading) {
      for (const auto* each : {&points.ramp_x, &points.ramp_y, &points.value_ramp_x, &points.value_ramp_y}) {
        add(each->data());
      }
    }
  }

 private:
  int add(const float* column) {
    columns[static_cast<std::size_t>(count)] = column;
    return count++;
  }
};

using Coefficients = std::array<double, most_columns>;

/// The solution of a symmetric positive system given as its lower rows (Cholesky); false where it has none.
bool solve(const double* lower, int n, const double* right, Coefficients& x) {
  double l[most_columns][most_columns];
  double per_diagonal[most_columns];
  for (int r = 0; r < n; ++r) {
    for (int s = 0; s <= r; ++s) {
      double sum = *lower++;
      if (r == s) sum += 1e-9 * sum + 1e-12;
      for (int k = 0; k < s; ++k) sum -= l[r][k] * l[s][k];
      if (r == s) {
        if (!(sum > 0.0)) return false;
        per_diagonal[r] = 1.0 / std::sqrt(sum);
      } else {
        l[r][s] = sum * per_diagonal[s];
      }
    }
  }
  for (int r = 0; r < n; ++r) {
    double sum = right[r];
    for (int k = 0; k < r; ++k) sum -= l[r][k] * x[static_cast<std::size_t>(k)];
    x[static_cast<std::size_t>(r)] = sum * per_diagonal[r];
  }
  for (int r = n - 1; r >= 0; --r) {
    double sum = x[static_cast<std::size_t>(r)];
    for (int k = r + 1; k < n; ++k) sum -= l[k][r] * x[static_cast<std::size_t>(k)];
    x[static_cast<std::size_t>(r)] = sum * per_diagonal[r];
  }
  return std::all_of(x.begin(), x.begin() + n, [](double each) { return std::isfinite(each); });
}

/// How much of the pattern's contrast a point may be off while the pose is still rough.
double rough_part(int iteration) { return iteration == 0 ? 0.6 : iteration == 1 ? 0.45 : 0.35; }

}  // namespace

void PoseFit::read_at(const PointArrays& points, const Projection& projection, const Reader& reader, const Pose& pose) {
  const std::size_t padded = points.near_x.size();
  image_.resize(padded);
  inside_.resize(padded);
  projection.place(pose, points, places_);
  reader.read(places_, points.count, image_.data(), inside_.data());
  std::fill(inside_.begin() + points.count, inside_.end(), 0.0F);
}

double PoseFit::correlation(const PointArrays& points, const Projection& projection, const Reader& reader,
                            const Pose& pose, double& inside) {
  read_at(points, projection, reader, pose);
  return correlation_as_read(points, inside);
}

double PoseFit::correlation_as_read(const PointArrays& points, double& inside) const {
  double sums[6];
  kernels::correlation_sums(image_.data(), points.value.data(), inside_.data(), points.count, sums);
  const double n = sums[0];
  inside = points.count == 0 ? 0.0 : n / points.count;
  if (n < 4.0) return 0.0;
  const double variance_i = n * sums[3] - sums[1] * sums[1];
  const double variance_t = n * sums[4] - sums[2] * sums[2];
  constexpr double flat = 0.05;  // grey levels: below, there is nothing to correlate with
  if (variance_i < flat * n * n || variance_t < flat * n * n) return 0.0;
  return (n * sums[5] - sums[1] * sums[2]) / std::sqrt(variance_i * variance_t);
}

PoseFit::Line PoseFit::agreeing_line(const PointArrays& points, int trusted, Polarity polarity) {
  Line best;
  const auto count = static_cast<std::size_t>(trusted);
  const auto contrast = static_cast<float>(points.contrast);
  constexpr std::size_t pairs = 40;
  constexpr std::size_t judges = 64;
  const std::size_t stride = std::max<std::size_t>(1, count / judges);
  judged_.clear();
  judged_target_.clear();
  judged_inside_.clear();
  for (std::size_t k = 0; k < count; k += stride) {
    judged_.push_back(image_[k]);
    judged_target_.push_back(points.value[k]);
    judged_inside_.push_back(inside_[k]);
  }
  const int number = static_cast<int>(judged_.size());
  for (auto* each : {&judged_, &judged_target_, &judged_inside_}) {
    each->resize(static_cast<std::size_t>(kernels::padded(number)), 0.0F);
  }
  float most = 0.0F;
  std::size_t at = 0;
  for (std::size_t m = 0; m < pairs; ++m) {
    // Two points of clearly different value.
    const std::size_t i = (m * 37 + at) % count;
    std::size_t j = i;
    float difference = 0.0F;
    for (std::size_t tries = 0; tries < 16 && std::abs(difference) < contrast; ++tries) {
      j = (j + 61 + tries * 7) % count;
      difference = points.value[j] - points.value[i];
      if (inside_[j] == 0.0F) difference = 0.0F;
    }
    at += 3;
    if (inside_[i] == 0.0F || std::abs(difference) < contrast) continue;
    const float gain = (image_[j] - image_[i]) / difference;
    if (std::abs(gain) < 0.03F || (polarity == Polarity::same && gain < 0.0F) ||
        (polarity == Polarity::reversed && gain > 0.0F)) {
      continue;
    }
    const float offset = image_[i] - gain * points.value[i];
    const float cut = 0.4F * std::abs(gain) * contrast;
    const float agreeing = kernels::agreement(judged_.data(), judged_target_.data(), judged_inside_.data(), number,
                                              gain, offset, 1.0F / cut);
    if (agreeing > most) {
      most = agreeing;
      best.gain = static_cast<double>(gain);
      best.offset = static_cast<double>(offset) - best.gain * points.mean;
    }
  }
  return best;
}

void PoseFit::update_turn_column(const PointArrays& points, const Pose& pose) {
  // A turn moves a point of the pattern across the axes by the ratio of the scales.
  const auto along_y = static_cast<float>(pose.scale_x / pose.scale_y);
  const auto along_x = static_cast<float>(pose.scale_y / pose.scale_x);
  const std::size_t padded = points.near_x.size();
  turn_column_.resize(padded);
  for (std::size_t k = 0; k < padded; ++k) turn_column_[k] = along_y * points.gy_x[k] - along_x * points.gx_y[k];
}

float PoseFit::spread_of_residuals(int trusted, double within) {
  scratch_.resize(residual_.size());
  const float median =
      kernels::median_below(residual_.data(), inside_.data(), static_cast<float>(within), trusted, scratch_.data());
  return 1.4826F * median;
}

FitResult PoseFit::fit(const PointArrays& points, const Projection& projection, const Reader& reader,
                       const FitOptions& options, Pose& pose) {
  FitResult result;
  Layout layout(options.freedom, points);
  const int columns = layout.count;
  if (points.count < columns) return result;
  const int trusted = options.trusted > 0 ? std::min(points.count, options.trusted) : points.count;
  const std::size_t padded = points.near_x.size();
  weight_.resize(padded);
  residual_.resize(padded);
  target_.resize(padded);
  if (options.freedom.common_scale) {
    growth_column_.resize(padded);
    for (std::size_t k = 0; k < padded; ++k) growth_column_[k] = points.gx_x[k] + points.gy_y[k];
    layout.columns[static_cast<std::size_t>(layout.scale_x)] = growth_column_.data();
  }
  layout.columns[static_cast<std::size_t>(columns)] = target_.data();
  const double contrast = points.contrast;
  const double level_scale = projection.level_from_plane_jacobian({pose.x, pose.y}).cwiseAbs().maxCoeff() *
                             projection.pitch * std::max(pose.scale_x, pose.scale_y);
  const auto is_pose = [&](int column) { return column >= layout.a && column < layout.first_nuisance; };

  Pose now = pose;
  Coefficients known{};  // of the picture at the pose: gain, offset and the nuisances; 0 for the pose
  Coefficients step{};
  double before = 0.0;  // how far the last step reached
  bool spread_known = false;
  double lower[most_columns * (most_columns + 1) / 2 + kernels::most_columns];
  constexpr double foreseeable = 0.02;  // level pixels
  constexpr int rough = 2;              // so many first steps do not trust the spread of the residuals
  for (int iteration = options.first_iteration;; ++iteration) {
    const bool first = iteration == options.first_iteration;
    const bool last = iteration - options.first_iteration >= options.iterations;
    if (first || before > foreseeable) {
      read_at(points, projection, reader, now);
    } else {
      // So little has changed that what would be read follows from the step.
      const auto a = static_cast<std::size_t>(layout.a);
      std::array<float, most_columns> by{};
      std::copy(step.begin() + layout.a, step.begin() + layout.first_nuisance, by.begin());
      kernels::residuals(layout.columns.data() + a, by.data(), layout.first_nuisance - layout.a, image_.data(),
                         points.count, image_.data());
    }
    if (layout.angle >= 0) {
      update_turn_column(points, now);
      layout.columns[static_cast<std::size_t>(layout.angle)] = turn_column_.data();
    }
    // Points that disagree lose their weight; those of the outline count once the others have found the way.
    const auto weigh = [&](const std::vector<float>& off, double cut, bool outline) {
      kernels::tukey_weights(off.data(), inside_.data(), static_cast<float>(1.0 / cut), points.count, weight_.data());
      if (!outline) std::fill(weight_.begin() + trusted, weight_.end(), 0.0F);
    };
    if (first && options.robust) {
      Line line = options.start;
      if (line.gain == 0.0) line = agreeing_line(points, trusted, options.polarity);
      if (line.gain == 0.0) return result;
      known[0] = line.gain;
      known[1] = line.offset + line.gain * points.mean;
    }
    std::array<float, most_columns> beta{};
    std::copy(known.begin(), known.end(), beta.begin());
    kernels::residuals(layout.columns.data(), beta.data(), columns, image_.data(), points.count, target_.data());
    if (first) {
      if (options.robust) {
        weigh(target_, (iteration == 0 ? 0.8 : rough_part(iteration)) * std::abs(known[0]) * contrast, iteration > 0);
      } else {
        std::copy(inside_.begin(), inside_.end(), weight_.begin());
        std::fill(weight_.begin() + trusted, weight_.end(), 0.0F);
      }
    }
    const bool reweight = options.robust && iteration > 0;
    for (int round = 0; round < (reweight ? 2 : 1); ++round) {
      kernels::normal_equations(layout.columns.data(), columns + 1, weight_.data(), points.count, lower);
      constexpr int of_offset = 2;  // row 1, column 1: the sum of the weights
      if (lower[of_offset] < columns + 1) return result;
      if (!solve(lower, columns, lower + columns * (columns + 1) / 2, step)) return result;
      std::copy(step.begin(), step.end(), beta.begin());
      kernels::residuals(layout.columns.data(), beta.data(), columns, target_.data(), points.count, residual_.data());
      const double gain = known[0] + step[0];
      const double by_contrast = std::abs(gain) * contrast * rough_part(iteration);
      const bool settling = options.robust && options.settle && iteration >= rough;
      if (last || settling || options.at_start_only) {
        // What disagrees grossly is hidden, and says nothing about the spread of the rest.
        const float spread = spread_of_residuals(trusted, options.robust ? by_contrast : 1e30);
        if (spread < 0.0F) return result;
        result.residual = static_cast<double>(spread);
        spread_known = true;
      }
      if (!options.robust) continue;
      const double least = 4.685 * options.noise_floor;
      weigh(residual_, std::max(least, settling ? std::min(4.685 * result.residual, by_contrast) : by_contrast),
            iteration > 0);
    }
    for (int r = 0; r < columns; ++r) {
      if (!is_pose(r)) known[static_cast<std::size_t>(r)] += step[static_cast<std::size_t>(r)];
    }
    const double gain = known[0];
    if (std::abs(gain) < 1e-3) return result;
    if (last) break;
    // β = −g·dp, so dp = −β/g.
    const auto moved = [&](int column) { return column < 0 ? 0.0 : -step[static_cast<std::size_t>(column)] / gain; };
    const double a = moved(layout.a);
    const double b = moved(layout.b);
    const double turn = moved(layout.angle);
    const double grow_x = moved(layout.scale_x);
    const double grow_y = options.freedom.common_scale ? grow_x : moved(layout.scale_y);
    // No step may leave the neighbourhood in which the linear model means anything.
    const double reach = std::max({std::hypot(a, b), std::abs(turn), std::abs(grow_x), std::abs(grow_y)}) * level_scale;
    constexpr double longest = 2.0;  // level pixels
    const double part = reach > longest ? longest / reach : 1.0;
    const double angle = now.angle_deg / degrees;
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    const double du = projection.pitch * now.scale_x * a * part;
    const double dv = projection.pitch * now.scale_y * b * part;
    now.x += c * du - s * dv;
    now.y += s * du + c * dv;
    now.angle_deg += turn / points.radius * part * degrees;
    now.scale_x *= 1.0 + grow_x / points.radius * part;
    now.scale_y *= 1.0 + grow_y / points.radius * part;
    if (!(now.scale_x > 0.05 && now.scale_y > 0.05 && now.scale_x < 20.0 && now.scale_y < 20.0)) return result;
    if (options.at_start_only) break;
    // Steps shrink by about the same ratio: the next one is foreseen.
    const double next = before > 0.0 ? reach * std::min(1.0, reach / before) : reach;
    before = reach;
    if (next < options.step_tolerance && (!options.settle || iteration >= rough)) break;
  }
  result.gain = known[0];
  result.offset = known[1] - known[0] * points.mean;
  std::array<float, most_columns> beta{};
  std::copy(known.begin(), known.end(), beta.begin());
  kernels::residuals(layout.columns.data(), beta.data(), columns, image_.data(), points.count, residual_.data());
  if (!spread_known) result.residual = std::max(0.0, static_cast<double>(spread_of_residuals(trusted, 1e30)));
  judge_view(points, result);
  if (options.try_shading) {
    result.shaded_residual =
        residual_with_shading(points, options, std::abs(result.gain) * contrast * rough_part(options.iterations));
  }
  if (options.covariance) {
    // Column by column of the inverse, by what solved the steps: positive where they were.
    Coefficients inverse[most_columns]{};
    for (int r = layout.a; r < layout.first_nuisance; ++r) {
      Coefficients unit_vector{};
      unit_vector[static_cast<std::size_t>(r)] = 1.0;
      if (!solve(lower, columns, unit_vector.data(), inverse[r])) return result;
    }
    const int where[5] = {layout.a, layout.b, layout.angle, layout.scale_x,
                          options.freedom.common_scale ? layout.scale_x : layout.scale_y};
    const double unit[5] = {1.0, 1.0, 1.0 / points.radius, now.scale_x / points.radius, now.scale_y / points.radius};
    for (int r = 0; r < 5; ++r) {
      for (int s = 0; s < 5; ++s) {
        if (where[r] < 0 || where[s] < 0) continue;
        result.covariance(r, s) =
            unit[r] * unit[s] * inverse[where[r]][static_cast<std::size_t>(where[s])] / (result.gain * result.gain);
      }
    }
  }
  result.ok = true;
  now.angle_deg = std::remainder(now.angle_deg, 360.0);
  pose = now;
  return result;
}

double PoseFit::residual_with_shading(const PointArrays& points, const FitOptions& options, double within) {
  Freedom freedom = options.freedom;
  freedom.shading = true;
  Layout layout(freedom, points);
  const int columns = layout.count;
  if (layout.angle >= 0) layout.columns[static_cast<std::size_t>(layout.angle)] = turn_column_.data();
  if (freedom.common_scale) layout.columns[static_cast<std::size_t>(layout.scale_x)] = growth_column_.data();
  target_ = residual_;
  layout.columns[static_cast<std::size_t>(columns)] = target_.data();
  double lower[most_columns * (most_columns + 1) / 2 + kernels::most_columns];
  kernels::normal_equations(layout.columns.data(), columns + 1, weight_.data(), points.count, lower);
  Coefficients step{};
  if (!solve(lower, columns, lower + columns * (columns + 1) / 2, step)) return 0.0;
  std::array<float, most_columns> beta{};
  std::copy(step.begin(), step.end(), beta.begin());
  kernels::residuals(layout.columns.data(), beta.data(), columns, target_.data(), points.count, residual_.data());
  const int trusted = options.trusted > 0 ? std::min(points.count, options.trusted) : points.count;
  return std::max(0.0, static_cast<double>(spread_of_residuals(trusted, within)));
}

void PoseFit::judge_view(const PointArrays& points, FitResult& result) const {
  constexpr float tolerated = 0.5F;  // of the pattern's contrast, less for the nearer ones
  constexpr double visible = 0.35;
  const double seen_contrast = std::abs(result.gain) * points.contrast;
  const auto visible_within = static_cast<float>(std::max(3.0 * result.residual, visible * seen_contrast));
  const float inverse_cut = 1.0F / (tolerated * static_cast<float>(seen_contrast));
  const kernels::ViewSums view = kernels::view_sums(residual_.data(), points.value.data(), image_.data(),
                                                    inside_.data(), points.count, inverse_cut, visible_within);
  const auto [weights, energy, left, sum, squares] = view.sums;
  const double n = points.count;
  result.inside = view.inside / n;
  result.visible = view.seen / n;
  const double spread = weights > 0.0 ? squares - sum * sum / weights : 0.0;
  if (spread > 0.0 && points.contrast > 0.0) {
    result.explained = std::sqrt(std::max(0.0, 1.0 - left / spread)) * energy / (n * points.contrast * points.contrast);
  }
}

}  // namespace vsfind
