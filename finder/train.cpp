#include "finder/train.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "acquisition/errors.h"
#include "finder/coarse_search.h"
#include "finder/edges.h"
#include "finder/impostors.h"
#include "finder/informative_points.h"
#include "finder/pattern_points.h"
#include "finder/pattern_spline.h"
#include "finder/search_points.h"
#include "finder/training_scene.h"
#include "finder/undetermined.h"

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
  if (options.edge_threshold &&
      !(*options.edge_threshold >= least_edge_threshold && *options.edge_threshold <= 255.0)) {
    throw UsageError(fmt::format("edge threshold {} is out of range (allowed: {} to 255, or auto)",
                                 *options.edge_threshold, least_edge_threshold));
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

[[noreturn]] void refuse_ranges(const GridSize& grid) {
  std::string wide;
  const auto name = [&wide](const char* key, double steps) {
    if (steps > 1.0) wide += fmt::format("{}{} ({:.0f} steps)", wide.empty() ? "" : ", ", key, steps);
  };
  name("angle", grid.angles);
  name("scale_x", grid.scales_x);
  name("scale_y", grid.scales_y);
  throw UsageError(fmt::format("the ranges ask for {:.0f} turned and scaled copies (allowed: at most {}); narrow {}",
                               grid.hypotheses(), most_hypotheses, wide));
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
  constexpr std::size_t least_points = 16;
  if (verify.points.size() < least_points) {
    throw UsageError(fmt::format("the mask leaves {} points of the pattern to compare (allowed: at least {})",
                                 verify.points.size(), least_points));
  }
  if (contrast_of(verify.points) < least_contrast) {
    throw UsageError(
        fmt::format("the pattern is flat: its grey values vary by {:.2f} (standard deviation; allowed: at "
                    "least {})",
                    contrast_of(verify.points), least_contrast));
  }

  const std::vector<PatternPoint> all = rough_points(scene);
  if (all.empty()) {
    throw UsageError(
        "the mask leaves no part of the pattern that is wide enough to be read (allowed: 5 pixels or more)");
  }

  std::vector<EdgeImage> other_edges(options.against.size());
  std::vector<Pyramid> pyramids(options.against.size());
  std::vector<OtherScene> others;
  for (std::size_t i = 0; i < options.against.size(); ++i) {
    ImageView other = options.against[i];
    if (options.edges) other = other_edges[i].compute(other, threshold);
    pyramids[i].build(other, scene.plan());
    others.push_back({other, &pyramids[i]});
  }

  const auto against_at = [&](int level) {
    std::vector<AgainstLevel> against;
    for (Pyramid& other : pyramids) {
      if (level < other.levels()) against.push_back({other.smoothed(level), mapping});
    }
    return against;
  };
  SearchPoints best;
  for (int level = deepest; level >= 0; --level) {
    // A finer level asks for finer steps: from here on there would be more copies than the search can try.
    const CoarseGrid grid = coarse_grid(scene, level, options);
    if (size_of(grid).hypotheses() > static_cast<double>(most_hypotheses)) {
      if (level == deepest) refuse_ranges(size_of(grid));
      break;
    }
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
  if (size_of(best.grid).hypotheses() > 1.0) {
    constexpr double widening = 1.4;
    constexpr double bearable = 0.75;
    constexpr double little = 0.05;
    SearchPoints wider = choose_search_points(scene, best.level, options, against_at(best.level), widening);
    if (!wider.points.empty() && wider.worst_genuine >= std::max(bearable, best.worst_genuine - little) &&
        wider.best_impostor <= best.best_impostor + little) {
      best = std::move(wider);
    }
  }
  pattern.top_level = best.level;
  pattern.angle_step_deg = options.angle_deg.searched() ? best.grid.angle_step_deg : 0.0;
  pattern.scale_step = options.scale_x.searched() || options.scale_y.searched() ? best.grid.scale_step : 0.0;
  pattern.sets.push_back({best.level, PointUse::search, best.points});
  for (int level = best.level; level >= (best.level == 0 ? 0 : 1); --level) {
    pattern.sets.push_back(follow_points(scene, options, level));
  }
  for (PointSet& set : refine_points(scene, options, all)) pattern.sets.push_back(std::move(set));
  pattern.sets.push_back(std::move(verify));
  expect_sigmas(pattern, options);
  pattern.image = pattern_image(scene, read);
  const Undetermined undetermined = undetermined_by(all, freedom_of(options), pattern.report.noise_sigma);
  pattern.report.warnings = warnings_of(undetermined, freedom_of(options));
  const std::vector<Impostor> impostors = find_impostors(scene, pattern, others);
  if (!impostors.empty()) {
    pattern.report.impostor_score = impostors.front().score;
    pattern.report.impostor = describe(impostors.front(), pattern);
  }
  for (std::string& warning : warnings_of(impostors, pattern, undetermined)) {
    pattern.report.warnings.push_back(std::move(warning));
  }

  pattern.report.training_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - started).count();
  return pattern;
}

}  // namespace vsfind
