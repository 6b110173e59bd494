#include "calibration/point_pairs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>

#include "acquisition/errors.h"
#include "calibration/key_reader.h"
#include "calibration/plane_fit.h"
#include "calibration/yaml_tree.h"

namespace vsfind {
namespace {

constexpr std::size_t most_pairs = 10000;
// Nobody clicks closer than this; what contradicts the rest by less is no mistake.
constexpr double harmless_pixels = 0.5;

const std::vector<std::string> column_names{"image_x", "image_y", "world_x", "world_y"};

std::vector<std::string> cells_of(std::string line) {
  if (!line.empty() && line.back() == '\r') line.pop_back();
  std::vector<std::string> cells;
  std::size_t begin = 0;
  for (;;) {
    const std::size_t comma = line.find(',', begin);
    std::string cell = line.substr(begin, comma == std::string::npos ? comma : comma - begin);
    const std::size_t first = cell.find_first_not_of(" \t");
    const std::size_t last = cell.find_last_not_of(" \t");
    cells.push_back(first == std::string::npos ? "" : cell.substr(first, last - first + 1));
    if (comma == std::string::npos || cells.size() > 64) return cells;
    begin = comma + 1;
  }
}

// Which of column_names each column is.
std::vector<std::size_t> read_header(const std::vector<std::string>& cells, const std::string& where) {
  std::vector<std::size_t> order;
  for (const std::string& cell : cells) {
    const auto found = std::find(column_names.begin(), column_names.end(), cell);
    if (found == column_names.end()) {
      throw UsageError(fmt::format("{}: '{}' is no column{} (allowed: image_x,image_y,world_x,world_y)", where,
                                   shown(cell), nearest_known(cell, column_names)));
    }
    order.push_back(static_cast<std::size_t>(found - column_names.begin()));
  }
  for (std::size_t i = 0; i < column_names.size(); ++i) {
    if (std::count(order.begin(), order.end(), i) != 1) {
      throw UsageError(fmt::format("{}: column {} must be there once (allowed: image_x,image_y,world_x,world_y)", where,
                                   column_names[i]));
    }
  }
  return order;
}

// Height of the flattest triangle over its longest side.
double flatness(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  const double longest = std::max({(b - a).norm(), (c - a).norm(), (c - b).norm()});
  if (!(longest > 0.0)) return 0.0;
  const Eigen::Vector2d u = b - a;
  const Eigen::Vector2d v = c - a;
  return std::abs(u.x() * v.y() - u.y() * v.x()) / (longest * longest);
}

// Four points determine the plane only if no three lie on a line, neither in the image nor in the world.
void check_general_position(const std::vector<PointPair>& p, const std::string& file) {
  for (std::size_t left_out = 0; left_out < 4; ++left_out) {
    std::array<std::size_t, 3> three{};
    for (std::size_t i = 0, n = 0; i < 4; ++i) {
      if (i != left_out) three[n++] = i;
    }
    const PointPair& a = p[three[0]];
    const PointPair& b = p[three[1]];
    const PointPair& c = p[three[2]];
    const bool image = flatness(a.image, b.image, c.image) < 1e-3;
    if (!image && !(flatness(a.world, b.world, c.world) < 1e-3)) continue;
    throw UsageError(
        fmt::format("{}: the points of lines {}, {} and {} lie on one straight line in the {}: four points must "
                    "be in general position, no three on a line",
                    file, a.line, b.line, c.line, image ? "image" : "world"));
  }
}

using Indices = std::vector<std::size_t>;

// Sets of four to try: all of few points, else a thousand drawn by a fixed generator.
std::vector<std::array<std::size_t, 4>> sets_of_four(std::size_t count) {
  std::vector<std::array<std::size_t, 4>> sets;
  if (count <= 12) {
    for (std::size_t a = 0; a < count; ++a) {
      for (std::size_t b = a + 1; b < count; ++b) {
        for (std::size_t c = b + 1; c < count; ++c) {
          for (std::size_t d = c + 1; d < count; ++d) sets.push_back({a, b, c, d});
        }
      }
    }
    return sets;
  }
  std::uint64_t state = 1;
  const auto draw = [&state, count] {
    state = state * 6364136223846793005U + 1442695040888963407U;
    return static_cast<std::size_t>((state >> 33U) % count);
  };
  while (sets.size() < 1000) {
    const std::array<std::size_t, 4> set{draw(), draw(), draw(), draw()};
    bool different = true;
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = i + 1; j < 4; ++j) different = different && set[i] != set[j];
    }
    if (different) sets.push_back(set);
  }
  return sets;
}

std::vector<double> distances(const Eigen::Matrix3d& h, const std::vector<Eigen::Vector2d>& world,
                              const std::vector<Eigen::Vector2d>& flat) {
  const Mapping mapping = Mapping::from_homography(h);
  std::vector<double> result;
  for (std::size_t i = 0; i < world.size(); ++i) {
    const double distance = (mapping.image_from_plane(world[i]) - flat[i]).norm();
    result.push_back(std::isnan(distance) ? std::numeric_limits<double>::infinity() : distance);
  }
  return result;
}

// The points that agree with each other, by the smallest median distance over many planes through four of them
// (Rousseeuw 1984), and then with their own least squares.
Indices agreeing_points(const std::vector<Eigen::Vector2d>& world, const std::vector<Eigen::Vector2d>& flat) {
  Indices all(world.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  if (world.size() < 6) return all;
  double best = std::numeric_limits<double>::infinity();
  std::vector<double> best_distances;
  for (const auto& set : sets_of_four(world.size())) {
    std::vector<Eigen::Vector2d> four_world, four_flat;
    for (const std::size_t i : set) {
      four_world.push_back(world[i]);
      four_flat.push_back(flat[i]);
    }
    try {
      std::vector<double> d = distances(fit_homography(four_world, four_flat), world, flat);
      std::vector<double> sorted = d;
      // The four themselves are met exactly; of the others at least half should be.
      const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>((sorted.size() + 5) / 2 - 1);
      std::nth_element(sorted.begin(), middle, sorted.end());
      if (*middle < best) {
        best = *middle;
        best_distances = std::move(d);
      }
    } catch (const UsageError&) {
      // These four determine no plane.
    }
  }
  if (best_distances.empty()) return all;
  const double scale = 1.4826 * (1.0 + 5.0 / static_cast<double>(world.size() - 4)) * best;
  const double limit = std::max(harmless_pixels, 2.5 * scale);
  const auto within = [&](const std::vector<double>& d) {
    Indices kept;
    for (const std::size_t i : all) {
      if (d[i] <= limit) kept.push_back(i);
    }
    return kept;
  };
  const Indices first = within(best_distances);
  std::vector<Eigen::Vector2d> kept_world, kept_flat;
  for (const std::size_t i : first) {
    kept_world.push_back(world[i]);
    kept_flat.push_back(flat[i]);
  }
  const Indices second = within(distances(fit_homography(kept_world, kept_flat), world, flat));
  return second.size() >= 4 ? second : first;
}

/// What was measured in a picture lies in it, or on its border at the furthest: anything else may be a slip of the pen,
/// or belong to a picture of another size.
std::vector<std::string> doubtful_points(const std::vector<PointPair>& pairs, const SolveOptions& options,
                                         const std::string& file) {
  std::vector<std::string> doubts;
  const int height = options.image_height / line_step(options.made_from);
  for (const PointPair& pair : pairs) {
    if (pair.image.x() >= -1.0 && pair.image.y() >= -1.0 && pair.image.x() <= options.image_width &&
        pair.image.y() <= height) {
      continue;
    }
    doubts.push_back(fmt::format("{}:{}: the image point {:g},{:g} lies outside the picture of {}x{}", file, pair.line,
                                 pair.image.x(), pair.image.y(), options.image_width, height));
  }
  return doubts;
}

}  // namespace

std::vector<PointPair> parse_point_pairs(const std::string& text, const std::string& file) {
  std::vector<PointPair> pairs;
  std::vector<std::size_t> order;
  std::size_t begin = text.starts_with("\xef\xbb\xbf") ? 3 : 0;
  for (int line = 1; begin < text.size(); ++line) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::vector<std::string> cells = cells_of(text.substr(begin, end - begin));
    begin = end + 1;
    if ((cells.size() == 1 && cells[0].empty()) || cells[0].starts_with('#')) continue;
    const std::string where = fmt::format("{}:{}", file, line);
    if (order.empty()) {
      order = read_header(cells, where);
      continue;
    }
    if (cells.size() != order.size()) {
      throw UsageError(fmt::format("{}: has {} values, must have {}", where, cells.size(), order.size()));
    }
    std::array<double, 4> values{};
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const auto value = decimal_number(cells[i]);
      if (!value || std::abs(*value) > 1e9) {
        throw UsageError(fmt::format("{}: {}: '{}' is no number (allowed: -1e9 to 1e9, '.' as the decimal point)",
                                     where, column_names[order[i]], shown(cells[i])));
      }
      values[order[i]] = *value;
    }
    if (pairs.size() == most_pairs) throw UsageError(fmt::format("{}: more than {} points", where, most_pairs));
    pairs.push_back({{values[0], values[1]}, {values[2], values[3]}, line});
  }
  if (order.empty()) throw UsageError(file + ": empty: its first line must be image_x,image_y,world_x,world_y");
  return pairs;
}

Solution solve_points(const std::vector<PointPair>& pairs, const SolveOptions& options, const std::string& file,
                      BoardView& used) {
  if (pairs.size() < 4) {
    throw UsageError(fmt::format("{}: has {} points, a plane needs at least four", file, pairs.size()));
  }
  if (pairs.size() == 4) check_general_position(pairs, file);
  const Mapping lines = Mapping().for_field(options.made_from);
  const Mapping flat_picture =
      options.lens ? Mapping::from_lens(*options.lens, undistorted_picture_plane(*options.lens)) : Mapping();
  std::vector<Eigen::Vector2d> world, frame, flat;
  for (const PointPair& pair : pairs) {
    world.push_back(pair.world);
    frame.push_back(lines.frame_from_image(pair.image));
    flat.push_back(flat_picture.plane_from_image(frame.back()));
    if (!flat.back().allFinite()) {
      throw UsageError(fmt::format("{}:{}: the lens model does not reach this image point", file, pair.line));
    }
  }
  try {
    (void)fit_homography(world, flat);
  } catch (const UsageError& error) {
    // With an outlier among many points the least squares of all may fail where those of the rest do not.
    if (pairs.size() < 6) throw UsageError(fmt::format("{}: {}", file, error.what()));
  }
  Solution solution;
  try {
    const Indices kept = agreeing_points(world, flat);
    used = {file, {}, {}, {}};
    for (const std::size_t i : kept) {
      used.board.push_back(world[i]);
      used.frame.push_back(frame[i]);
    }
    SolveOptions plane_only = options;
    plane_only.solve_lens = false;
    plane_only.plane_view = 0;
    solution = solve_views({used}, plane_only);
    const Mapping mapping = mapping_of(solution.calibration);
    solution.warnings = doubtful_points(pairs, options, file);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (std::find(kept.begin(), kept.end(), i) != kept.end()) continue;
      const double distance = (mapping.image_from_plane(world[i]) - frame[i]).norm();
      solution.warnings.push_back(fmt::format("{}:{}: lies {:.2f} px from where the other points put it: left out",
                                              file, pairs[i].line, distance));
    }
  } catch (const UsageError& error) {
    throw UsageError(fmt::format("{}: {}", file, error.what()));
  }
  if (solution.calibration.residuals.rms > 1.0) {
    solution.warnings.push_back(
        fmt::format("{}: the points disagree by {:.2f} px (rms); {}", file, solution.calibration.residuals.rms,
                    pairs.size() < 6 ? "which one is wrong takes six points to tell" : "does the lens bend lines?"));
  }
  return solution;
}

}  // namespace vsfind
