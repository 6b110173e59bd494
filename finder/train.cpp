#include "finder/train.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "acquisition/errors.h"
#include "finder/edges.h"
#include "finder/informative_points.h"
#include "finder/pattern_spline.h"
#include "finder/search_points.h"
#include "finder/training_scene.h"

namespace vsfind {

namespace {

constexpr int smallest_roi = 8;
constexpr int deepest_level = 7;

void check_range(const char* key, const Range& range, double least, double most) {
  if (!(range.min <= range.max && range.min >= least && range.max <= most)) {
    throw UsageError(fmt::format("{} {}:{} is not a range (allowed: MIN:MAX with {} <= MIN <= MAX <= {})", key,
                                 range.min, range.max, least, most));
  }
}

void check(const ImageView& image, const TrainOptions& options) {
  const Roi& roi = options.roi;
  if (image.empty()) throw UsageError("the training image is empty");
  if (roi.width < smallest_roi || roi.height < smallest_roi) {
    throw UsageError(fmt::format("roi {},{},{},{} is too small (allowed: at least {} x {} pixels)", roi.x, roi.y,
                                 roi.width, roi.height, smallest_roi, smallest_roi));
  }
  if (roi.x < 0 || roi.y < 0 || roi.width > image.width || roi.height > image.height ||
      roi.x > image.width - roi.width || roi.y > image.height - roi.height) {
    throw UsageError(fmt::format("roi {},{},{},{} reaches outside the image of {} x {} pixels", roi.x, roi.y, roi.width,
                                 roi.height, image.width, image.height));
  }
  check_range("angle", options.angle_deg, -360.0, 360.0);
  if (options.angle_deg.width() > 360.0 + 1e-9) {
    throw UsageError(fmt::format("angle {}:{} is wider than a full circle (allowed: at most 360 degrees wide)",
                                 options.angle_deg.min, options.angle_deg.max));
  }
  check_range("scale_x", options.scale_x, 0.5, 2.0);
  check_range("scale_y", options.scale_y, 0.5, 2.0);
  if (options.accuracy < 1 || options.accuracy > 100) {
    throw UsageError(fmt::format("accuracy {} is out of range (allowed: 1 to 100)", options.accuracy));
  }
  if (options.edge_threshold && !(*options.edge_threshold > 0.0 && *options.edge_threshold <= 255.0)) {
    throw UsageError(fmt::format("edge threshold {} is out of range (allowed: above 0 up to 255, or auto)",
                                 *options.edge_threshold));
  }
  const ImageView& mask = options.mask;
  if (!mask.empty() && !(mask.width == roi.width && mask.height == roi.height) &&
      !(mask.width == image.width && mask.height == image.height)) {
    throw UsageError(
        fmt::format("the mask has {} x {} pixels (allowed: the size of the roi, {} x {}, or of the image, "
                    "{} x {})",
                    mask.width, mask.height, roi.width, roi.height, image.width, image.height));
  }
}

Freedom freedom_of(const TrainOptions& options) {
  Freedom freedom;
  freedom.angle = options.angle_deg.searched();
  freedom.common_scale = options.common_scale && options.scale_x.searched();
  freedom.scale_x = options.scale_x.searched();
  freedom.scale_y = options.scale_y.searched();
  return freedom;
}

/// Points of a level's picture with their gradients, from the whole pattern.
std::vector<PatternPoint> level_points(TrainingScene& scene, int index) {
  const Level& level = scene.pyramid().smoothed(index);
  const double step = std::ldexp(1.0, index);
  const BilinearReader reader(level);
  const Projection projection = scene.projection(level);
  std::vector<PatternPoint> points;
  for (const Eigen::Vector2d& at : scene.lattice(step, step / 2.0 - 1e-6)) {
    const double x[5] = {at.x(), at.x() - step, at.x() + step, at.x(), at.x()};
    const double y[5] = {at.y(), at.y(), at.y(), at.y() - step, at.y() + step};
    double u[5], v[5], value[5], inside[5];
    projection.level_from_pattern(scene.pose(), x, y, 5, u, v);
    reader.read(u, v, 5, value, inside);
    if (*std::min_element(inside, inside + 5) == 0.0) continue;
    PatternPoint p;
    p.x = at.x();
    p.y = at.y();
    p.value = static_cast<float>(value[0]);
    p.gradient_x = static_cast<float>((value[2] - value[1]) / (2.0 * step));
    p.gradient_y = static_cast<float>((value[4] - value[3]) / (2.0 * step));
    points.push_back(p);
  }
  return points;
}

/// A point of full resolution read through the Gaussian that the search uses too.
bool read_fine(const TrainingScene& scene, const GaussianReader& reader, PatternPoint& p) {
  const Eigen::Vector2d plane(scene.pose().x + scene.pitch() * p.x, scene.pose().y + scene.pitch() * p.y);
  const Eigen::Vector2d image = scene.mapping().image_from_plane(plane);
  double read[4];
  if (!reader.read_with_derivatives(image.x(), image.y(), read)) return false;
  const Eigen::Matrix2d jacobian = scene.mapping().image_from_plane_jacobian(plane) * scene.pitch();
  p.value = static_cast<float>(read[0]);
  p.gradient_x = static_cast<float>(read[1] * jacobian(0, 0) + read[2] * jacobian(1, 0));
  p.gradient_y = static_cast<float>(read[1] * jacobian(0, 1) + read[2] * jacobian(1, 1));
  // Exact for square pixels; elsewhere near enough for what it is: a nuisance that takes up differences in sharpness.
  p.laplacian = static_cast<float>(read[3] * std::abs(jacobian.determinant()));
  return true;
}

std::vector<PatternPoint> pick(const std::vector<PatternPoint>& all, const std::vector<std::size_t>& chosen) {
  std::vector<PatternPoint> points;
  points.reserve(chosen.size());
  for (const std::size_t k : chosen) points.push_back(all[k]);
  return points;
}

/// Every pixel of the pattern read through the Gaussian, with derivatives from its neighbours: rough ones, for
/// choosing.
std::vector<PatternPoint> rough_points(TrainingScene& scene) {
  constexpr double border = 2.0;  // the kernel's reach: what lies around the pattern is not part of it
  const std::vector<Eigen::Vector2d> lattice = scene.lattice(1.0, border);
  if (lattice.empty()) return {};
  Eigen::Vector2d least = lattice.front();
  Eigen::Vector2d most = lattice.front();
  for (const Eigen::Vector2d& at : lattice) {
    least = least.cwiseMin(at);
    most = most.cwiseMax(at);
  }
  // One reading per pixel, one pixel more all around.
  const auto columns = static_cast<std::size_t>(std::lround(most.x() - least.x())) + 3;
  const auto rows = static_cast<std::size_t>(std::lround(most.y() - least.y())) + 3;
  const std::size_t n = columns * rows;
  std::vector<double> x(n), y(n), u(n), v(n), value(n), inside(n);
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t row = k / columns;
    x[k] = least.x() - 1.0 + static_cast<double>(k % columns);
    y[k] = least.y() - 1.0 + static_cast<double>(row);
  }
  scene.projection(scene.pyramid().level(0))
      .level_from_pattern(scene.pose(), x.data(), y.data(), static_cast<int>(n), u.data(), v.data());
  scene.gaussian().read(u.data(), v.data(), static_cast<int>(n), value.data(), inside.data());
  std::vector<PatternPoint> points;
  for (const Eigen::Vector2d& at : lattice) {
    const std::size_t k = (static_cast<std::size_t>(std::lround(at.y() - least.y())) + 1) * columns +
                          static_cast<std::size_t>(std::lround(at.x() - least.x())) + 1;
    if (inside[k] * inside[k - 1] * inside[k + 1] * inside[k - columns] * inside[k + columns] == 0.0) continue;
    PatternPoint p;
    p.x = at.x();
    p.y = at.y();
    p.value = static_cast<float>(value[k]);
    p.gradient_x = static_cast<float>((value[k + 1] - value[k - 1]) / 2.0);
    p.gradient_y = static_cast<float>((value[k + columns] - value[k - columns]) / 2.0);
    p.laplacian =
        static_cast<float>(value[k - 1] + value[k + 1] + value[k - columns] + value[k + columns] - 4.0 * value[k]);
    points.push_back(p);
  }
  return points;
}

/// Whether each point lies at the pattern's outermost edges, seen from its middle.
std::vector<char> on_outline(const std::vector<PatternPoint>& points) {
  constexpr double reach = 4.0;        // pattern pixels: an edge and the kernel's width
  constexpr double significant = 0.2;  // of the strongest gradients
  std::vector<float> strengths;
  Eigen::Vector2d middle(0.0, 0.0);
  for (const PatternPoint& p : points) {
    strengths.push_back(std::hypot(p.gradient_x, p.gradient_y));
    middle += Eigen::Vector2d(p.x, p.y) / static_cast<double>(points.size());
  }
  std::vector<float> sorted = strengths;
  const auto high = sorted.begin() + static_cast<std::ptrdiff_t>(static_cast<double>(sorted.size() - 1) * 0.99);
  std::nth_element(sorted.begin(), high, sorted.end());
  const float least = static_cast<float>(significant) * *high;
  constexpr int sectors = 360;
  const auto sector = [&](const PatternPoint& p) {
    const double turn = std::atan2(p.y - middle.y(), p.x - middle.x()) / (2.0 * std::numbers::pi) + 0.5;
    return static_cast<std::size_t>(std::clamp(static_cast<int>(turn * sectors), 0, sectors - 1));
  };
  const auto radius = [&](const PatternPoint& p) { return std::hypot(p.x - middle.x(), p.y - middle.y()); };
  std::vector<double> outermost(sectors, 0.0);
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (strengths[k] >= least) outermost[sector(points[k])] = std::max(outermost[sector(points[k])], radius(points[k]));
  }
  std::vector<char> outline(points.size(), 0);
  for (std::size_t k = 0; k < points.size(); ++k) {
    // A neighbouring sector may hold the edge where this one just misses it. Along a slanted ray an edge is deeper.
    const std::size_t s = sector(points[k]);
    const double edge = std::max({outermost[s], outermost[(s + 1) % sectors], outermost[(s + sectors - 1) % sectors]});
    const double g = std::max(1e-6, static_cast<double>(strengths[k]));
    const double slant = std::abs(static_cast<double>(points[k].gradient_x) * (points[k].x - middle.x()) +
                                  static_cast<double>(points[k].gradient_y) * (points[k].y - middle.y())) /
                         (g * std::max(1e-6, radius(points[k])));
    if (radius(points[k]) > edge - reach / std::max(0.5, slant)) outline[k] = 1;
  }
  return outline;
}

/// The points of the sub-pixel pose: inner ones, then those of the outline.
std::vector<PointSet> refine_points(TrainingScene& scene, const TrainOptions& options) {
  const std::vector<PatternPoint> all = rough_points(scene);
  if (all.empty()) return {};
  const std::vector<char> outer = on_outline(all);
  std::vector<PatternPoint> inner_candidates;
  std::vector<PatternPoint> outer_candidates;
  for (std::size_t k = 0; k < all.size(); ++k) (outer[k] != 0 ? outer_candidates : inner_candidates).push_back(all[k]);
  // 15 points per step of accuracy: 30 gives the 450 points that come near the bound of all pixels.
  const auto count = static_cast<std::size_t>(std::lround(10.0 + 15.0 * options.accuracy));
  constexpr double spacing = 2.0;  // nearer ones read the same pixels and tell nothing new
  // Gain, offset and sharpness count among what the points must settle: points on one flank of the edges only would
  // take a difference in any of them for a shift.
  Freedom freedom = freedom_of(options);
  freedom.blur = true;
  const auto choose = [&](const std::vector<PatternPoint>& candidates, std::size_t number, PointUse use) {
    PointSet set{0, use, pick(candidates, choose_informative(candidates, freedom, number, spacing, options.spread))};
    std::erase_if(set.points, [&](PatternPoint& p) { return !read_fine(scene, scene.gaussian(), p); });
    return set;
  };
  const auto strength = [](const std::vector<PatternPoint>& points) {
    double sum = 0.0;
    for (const PatternPoint& p : points) {
      sum += static_cast<double>(p.gradient_x) * static_cast<double>(p.gradient_x) +
             static_cast<double>(p.gradient_y) * static_cast<double>(p.gradient_y);
    }
    return sum;
  };
  // A pattern that is all outline has nothing else to trust.
  constexpr double least_inner_part = 0.15;
  if (strength(inner_candidates) < least_inner_part * strength(all)) return {choose(all, count, PointUse::refine)};
  const std::size_t outline = count * 2 / 5;
  return {choose(inner_candidates, count - outline, PointUse::refine),
          choose(outer_candidates, outline, PointUse::outline)};
}

/// Evenly spread over the whole pattern, flat parts too: what the score is measured on.
PointSet verify_points(const TrainingScene& scene) {
  constexpr double wanted = 600.0;
  PointSet set{0, PointUse::verify, {}};
  const GaussianReader reader = scene.gaussian();
  const double step = std::max(1.0, std::sqrt(scene.width() * scene.height() / wanted));
  for (const Eigen::Vector2d& at : scene.lattice(step, 0.0)) {
    PatternPoint p;
    p.x = at.x();
    p.y = at.y();
    if (read_fine(scene, reader, p)) set.points.push_back(p);
  }
  return set;
}

PointSet follow_points(TrainingScene& scene, const TrainOptions& options, int level) {
  constexpr std::size_t count = 128;
  const std::vector<PatternPoint> all = level_points(scene, level);
  // Spread, so that hidden parts leave enough; the rest of the choice is by information.
  return {level, PointUse::follow,
          pick(all, choose_informative(all, freedom_of(options), count, std::ldexp(1.0, level) * 0.9, true))};
}

/// Standard deviation of the values of points.
double contrast_of(const std::vector<PatternPoint>& points) {
  double sum = 0.0;
  double squares = 0.0;
  for (const PatternPoint& p : points) {
    sum += static_cast<double>(p.value);
    squares += static_cast<double>(p.value) * static_cast<double>(p.value);
  }
  const auto n = static_cast<double>(std::max<std::size_t>(1, points.size()));
  return std::sqrt(std::max(0.0, squares / n - (sum / n) * (sum / n)));
}

PatternImage pattern_image(const TrainingScene& scene, const ImageView& image) {
  PatternImage picture;
  constexpr int margin = 4;
  picture.width = static_cast<int>(std::lround(scene.width())) + 2 * margin;
  picture.height = static_cast<int>(std::lround(scene.height())) + 2 * margin;
  const double x0 = scene.left() + 0.5 - margin;
  const double y0 = scene.top() + 0.5 - margin;
  picture.origin_x = -x0;
  picture.origin_y = -y0;
  // Through a mapping the grid falls between the image's pixels: they are interpolated without blurring them.
  PatternImage source;
  source.width = image.width;
  source.height = image.height;
  const double white = image.white();
  source.grey.reserve(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      source.grey.push_back(static_cast<std::uint16_t>(std::lround(image.at(x, y) / white * 65280.0)));
    }
  }
  source.mask.assign(source.grey.size(), 255);
  const PatternSpline spline(source);
  for (int r = 0; r < picture.height; ++r) {
    for (int c = 0; c < picture.width; ++c) {
      const double x = x0 + c;
      const double y = y0 + r;
      const Eigen::Vector2d p =
          scene.mapping().image_from_plane({scene.pose().x + scene.pitch() * x, scene.pose().y + scene.pitch() * y});
      const bool seen = p.x() > -0.5 && p.y() > -0.5 && p.x() < image.width - 0.5 && p.y() < image.height - 0.5;
      double grey = 0.0;
      if (seen) {
        PatternPoint point;
        const double u = std::clamp(p.x(), 0.0, image.width - 1.0);
        const double v = std::clamp(p.y(), 0.0, image.height - 1.0);
        const bool inner = spline.read(u, v, point);
        grey = inner ? 256.0 * static_cast<double>(point.value)
                     : 65280.0 / white * image.at(static_cast<int>(std::lround(u)), static_cast<int>(std::lround(v)));
      }
      picture.grey.push_back(static_cast<std::uint16_t>(std::lround(std::clamp(grey, 0.0, 65280.0))));
      picture.mask.push_back(!seen                         ? std::uint8_t{0}
                             : scene.in_pattern(x, y, 0.0) ? std::uint8_t{255}
                                                           : std::uint8_t{128});
    }
  }
  return picture;
}

/// Noise of a picture around the ROI: median of the second differences, which structure leaves alone (after Immerkær
/// 1996).
double estimate_noise(const ImageView& image, const Roi& roi) {
  std::vector<double> values;
  const int right = std::min(image.width - 1, roi.x + roi.width);
  const int bottom = std::min(image.height - 1, roi.y + roi.height);
  for (int y = std::max(1, roi.y); y < bottom; ++y) {
    for (int x = std::max(1, roi.x); x < right; ++x) {
      const int m = image.at(x - 1, y - 1) - 2 * image.at(x, y - 1) + image.at(x + 1, y - 1) -
                    2 * (image.at(x - 1, y) - 2 * image.at(x, y) + image.at(x + 1, y)) + image.at(x - 1, y + 1) -
                    2 * image.at(x, y + 1) + image.at(x + 1, y + 1);
      values.push_back(std::abs(m));
    }
  }
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return 1.4826 * *middle / 6.0 * 255.0 / image.white();
}

/// Expected standard deviations at an image noise of 2 grey levels: the inverse of the refine points' information, with
/// gain, offset and sharpness in it (Cramér-Rao).
void expect_sigmas(Pattern& pattern, const TrainOptions& options) {
  std::vector<PatternPoint> points;
  for (const PointSet& set : pattern.sets) {
    if (set.use == PointUse::refine || set.use == PointUse::outline) {
      points.insert(points.end(), set.points.begin(), set.points.end());
    }
  }
  if (points.empty()) return;
  Freedom freedom = freedom_of(options);
  freedom.blur = true;
  const Eigen::Index size = pose_derivatives(points.front(), freedom).size();
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(size, size);
  for (const PatternPoint& point : points) {
    const Eigen::VectorXd j = pose_derivatives(point, freedom);
    information += j * j.transpose();
  }
  information.diagonal().array() *= 1.0 + 1e-9;
  const Eigen::VectorXd variance = information.inverse().diagonal().cwiseMax(0.0);
  // Noise of the picture and of the pattern, each averaged by the kernel: white noise of 1 leaves 1 / (2·√π·σ).
  constexpr double image_noise = 2.0;
  const double noise =
      std::hypot(image_noise, pattern.report.noise_sigma) / (2.0 * std::sqrt(std::numbers::pi) * reading_sigma);
  const PointInflation inflation = inflation_of(points, freedom);
  pattern.report.sigma_x = pattern.pitch * noise * std::sqrt(variance(0) * inflation(0));
  pattern.report.sigma_y = pattern.pitch * noise * std::sqrt(variance(1) * inflation(1));
  pattern.report.sigma_angle_deg =
      freedom.angle ? noise * std::sqrt(variance(2) * inflation(2)) * 180.0 / std::numbers::pi : 0.0;
}

}  // namespace

Pattern train(const ImageView& image, const Mapping& mapping, const TrainOptions& options) {
  const auto started = std::chrono::steady_clock::now();
  check(image, options);
  EdgeImage edges;
  double threshold = 0.0;
  ImageView read = image;
  if (options.edges) {
    threshold = options.edge_threshold ? *options.edge_threshold : automatic_edge_threshold(image, options.roi);
    read = edges.compute(image, threshold);
  }
  const double shorter = std::min(options.roi.width, options.roi.height);
  int deepest = 0;
  while (deepest < deepest_level && shorter / std::ldexp(1.0, deepest + 1) >= 7.0) ++deepest;
  TrainingScene scene(read, mapping, options, deepest);
  deepest = std::min(deepest, scene.pyramid().levels() - 1);

  Pattern pattern;
  pattern.name = options.name;
  pattern.unit = options.unit;
  pattern.pitch = scene.pitch();
  pattern.pixel_aspect = mapping.pixel_aspect();
  pattern.from_field = mapping.field() != Field::frame;
  pattern.left = scene.left();
  pattern.top = scene.top();
  pattern.width = scene.width();
  pattern.height = scene.height();
  pattern.angle_deg = options.angle_deg;
  pattern.scale_x = options.scale_x;
  pattern.scale_y = options.common_scale ? options.scale_x : options.scale_y;
  pattern.common_scale = options.common_scale;
  pattern.accuracy = options.accuracy;
  pattern.edges = options.edges;
  pattern.edge_threshold = threshold;
  pattern.spread = options.spread;
  pattern.polarity = options.polarity;
  pattern.report.noise_sigma = estimate_noise(image, options.roi);

  PointSet verify = verify_points(scene);
  constexpr double least_contrast = 1.0;  // grey levels
  if (verify.points.size() < 16 || contrast_of(verify.points) < least_contrast) {
    throw UsageError(
        fmt::format("the pattern is flat: its grey values vary by {:.2f} (standard deviation; allowed: at "
                    "least {})",
                    contrast_of(verify.points), least_contrast));
  }

  std::vector<EdgeImage> other_edges(options.against.size());
  std::vector<Pyramid> others(options.against.size());
  for (std::size_t i = 0; i < options.against.size(); ++i) {
    ImageView other = options.against[i];
    if (options.edges) other = other_edges[i].compute(other, threshold);
    others[i].build(other, scene.plan());
  }

  const auto against_at = [&](int level) {
    std::vector<AgainstLevel> against;
    for (Pyramid& other : others) {
      if (level < other.levels()) against.push_back({other.smoothed(level), mapping});
    }
    return against;
  };
  SearchPoints best;
  for (int level = deepest; level >= 0; --level) {
    SearchPoints proposal = choose_search_points(scene, level, options, against_at(level));
    if (proposal.points.size() < 4) continue;
    // Where much in the scene looks like the pattern (its own kind, say) no level tells them apart: the candidates are
    // followed down and judged there.
    constexpr double enough_pixels = 12.0;
    const bool tolerant = proposal.worst_genuine >= 0.8 && shorter / std::ldexp(1.0, level) >= enough_pixels;
    const bool good = proposal.worst_genuine >= 0.7 && (proposal.margin() >= 0.15 || tolerant);
    if (best.points.empty() || proposal.margin() > best.margin()) best = std::move(proposal);
    if (good) break;
  }
  if (best.points.empty())
    throw UsageError("the pattern has too few points that can be searched for: choose a larger roi");
  // The grid need be no finer than the points bear.
  const bool turned_or_scaled =
      options.angle_deg.width() > best.grid.angle_step_deg || options.scale_x.searched() || options.scale_y.searched();
  for (const double widening : {1.4}) {
    if (!turned_or_scaled) break;
    SearchPoints wider = choose_search_points(scene, best.level, options, against_at(best.level), widening);
    constexpr double bearable = 0.75;
    constexpr double little = 0.05;
    if (wider.points.empty() || wider.worst_genuine < std::max(bearable, best.worst_genuine - little) ||
        wider.best_impostor > best.best_impostor + little) {
      continue;
    }
    best = std::move(wider);
    break;
  }
  pattern.top_level = best.level;
  pattern.angle_step_deg = options.angle_deg.searched() ? best.grid.angle_step_deg : 0.0;
  pattern.scale_step = options.scale_x.searched() || options.scale_y.searched() ? best.grid.scale_step : 0.0;
  pattern.report.impostor_score = best.best_impostor;
  pattern.sets.push_back({best.level, PointUse::search, best.points});
  for (int level = best.level; level >= (best.level == 0 ? 0 : 1); --level) {
    pattern.sets.push_back(follow_points(scene, options, level));
  }
  for (PointSet& set : refine_points(scene, options)) pattern.sets.push_back(std::move(set));
  pattern.sets.push_back(std::move(verify));
  expect_sigmas(pattern, options);
  pattern.image = pattern_image(scene, read);

  pattern.report.training_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - started).count();
  return pattern;
}

}  // namespace vsfind
