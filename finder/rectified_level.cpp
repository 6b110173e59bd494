#include "finder/rectified_level.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "finder/kernels.h"

namespace vsfind {

namespace {

constexpr std::size_t most_tables = 4;
constexpr int lattice_steps = 16;
constexpr double smallest_scale = 1.0 / 3.0;  // of that in the middle: what is seen smaller has no pattern to show
constexpr double most_growth = 3.0;           // the grid's pixels for one of the level's

Eigen::Matrix2d level_slope(const Level& level, const Mapping& mapping, const Eigen::Vector2d& plane) {
  Eigen::Matrix2d slope = mapping.image_from_plane_jacobian(plane);
  slope.row(0) /= level.step_x;
  slope.row(1) /= level.step_y;
  return slope;
}

Eigen::Vector2d plane_from_level(const Level& level, const Mapping& mapping, const Eigen::Vector2d& p) {
  return mapping.plane_from_image(level.image_from_level(p));
}

double largest_singular_value(const Eigen::Matrix2d& m) {
  // Of AᵀA, in closed form.
  const double a = m.squaredNorm();
  const double d = m.determinant();
  return std::sqrt(0.5 * (a + std::sqrt(std::max(0.0, a * a - 4.0 * d * d))));
}

}  // namespace

RectifiedLevel::Table RectifiedLevel::make_table(const Level& level, const Mapping& mapping) {
  Table table;
  table.mapping = mapping;
  table.width = level.width;
  table.height = level.height;
  table.step_x = level.step_x;
  table.step_y = level.step_y;
  if (mapping.affine()) return table;
  const Eigen::Vector2d middle((level.width - 1) / 2.0, (level.height - 1) / 2.0);
  const Eigen::Vector2d plane = plane_from_level(level, mapping, middle);
  const Eigen::Matrix2d slope = level_slope(level, mapping, plane);
  if (!plane.allFinite() || !slope.allFinite() || !(std::abs(slope.determinant()) > 0.0)) return table;
  const Eigen::Matrix2d inverse = slope.inverse();
  table.scale = std::sqrt(std::abs(slope.determinant()));

  // What of the plane the picture shows, large enough; where it would be too much, only what is seen still larger.
  Eigen::Vector2d low;
  Eigen::Vector2d high;
  double largest_scale = 1.0;
  for (double least = smallest_scale;; least *= 1.2) {
    low = high = Eigen::Vector2d::Zero();
    table.change = 0.0;
    for (int j = 0; j <= lattice_steps; ++j) {
      for (int i = 0; i <= lattice_steps; ++i) {
        const Eigen::Vector2d at(-0.5 + static_cast<double>(level.width) * i / lattice_steps,
                                 -0.5 + static_cast<double>(level.height) * j / lattice_steps);
        const Eigen::Vector2d there = plane_from_level(level, mapping, at);
        if (!there.allFinite()) continue;
        const Eigen::Matrix2d relative = level_slope(level, mapping, there) * inverse;
        const double scale = std::sqrt(std::abs(relative.determinant()));
        if (!(scale >= least)) continue;
        largest_scale = std::max(largest_scale, scale);
        table.change = std::max(table.change, largest_singular_value(relative - Eigen::Matrix2d::Identity()));
        const Eigen::Vector2d on_grid = slope * (there - plane);
        low = low.cwiseMin(on_grid);
        high = high.cwiseMax(on_grid);
      }
    }
    const Eigen::Vector2d size = high - low;
    if (least >= 1.0 || size.prod() <= most_growth * level.width * level.height) break;
  }
  // The level is smooth: reading every second of its pixels is the limit.
  constexpr double one_sample = 1.6;
  // What is seen farther away has no more to show than its own pixels: the grid has no more of them than the level, as
  // far as one reading for each does.
  const double shrunk = std::clamp(std::sqrt(level.width * level.height / std::max(1.0, (high - low).prod())),
                                   std::min(1.0, largest_scale / one_sample), 1.0);
  low *= shrunk;
  high *= shrunk;
  table.grid_width = static_cast<int>(std::ceil(high.x() - low.x())) + 1;
  table.grid_height = static_cast<int>(std::ceil(high.y() - low.y())) + 1;
  Eigen::Matrix3d grid_from_plane = Eigen::Matrix3d::Identity();
  grid_from_plane.topLeftCorner<2, 2>() = shrunk * slope;
  grid_from_plane.topRightCorner<2, 1>() = -shrunk * slope * plane - low;
  table.grid_mapping = Mapping::from_homography(grid_from_plane);
  table.samples = std::clamp(static_cast<int>(std::ceil(largest_scale / shrunk / one_sample - 1e-9)), 1, 4);
  table.usable = table.grid_width >= 8 && table.grid_height >= 8;
  return table;
}

void RectifiedLevel::add_taps(const Level& level, Table& table) {
  const int n = table.samples;
  const auto columns = static_cast<std::size_t>(table.grid_width) * static_cast<std::size_t>(n);
  const auto rows = static_cast<std::size_t>(table.grid_height) * static_cast<std::size_t>(n);
  table.taps.assign(columns * rows, {});
  table.shown.assign(static_cast<std::size_t>(table.grid_height), {});
  std::vector<double> x(columns);
  std::vector<double> y(columns);
  std::vector<double> u(columns);
  std::vector<double> v(columns);
  for (std::size_t r = 0; r < rows; ++r) {
    for (std::size_t c = 0; c < columns; ++c) {
      const Eigen::Vector2d plane = table.grid_mapping.plane_from_image(
          {(static_cast<double>(c) + 0.5) / n - 0.5, (static_cast<double>(r) + 0.5) / n - 0.5});
      x[c] = plane.x();
      y[c] = plane.y();
    }
    table.mapping.image_from_plane(std::span<const double>(x), y, u, v);
    for (std::size_t c = 0; c < columns; ++c) {
      Eigen::Vector2d p = level.level_from_image({u[c], v[c]});
      constexpr double border = 0.5;  // half a pixel around belongs to the picture, too
      if (!(p.x() >= -border && p.y() >= -border && p.x() <= level.width - 1 + border &&
            p.y() <= level.height - 1 + border)) {
        continue;
      }
      p.x() = std::clamp(p.x(), 0.0, level.width - 1.0);
      p.y() = std::clamp(p.y(), 0.0, level.height - 1.0);
      const int column = std::min(static_cast<int>(p.x()), level.width - 2);
      const int row = std::min(static_cast<int>(p.y()), level.height - 2);
      Tap& tap =
          table.taps[(r / static_cast<std::size_t>(n) * static_cast<std::size_t>(table.grid_width) +
                      c / static_cast<std::size_t>(n)) *
                         static_cast<std::size_t>(n * n) +
                     r % static_cast<std::size_t>(n) * static_cast<std::size_t>(n) + c % static_cast<std::size_t>(n)];
      tap.at = column + row * level.width;
      ColumnRange& shown = table.shown[r / static_cast<std::size_t>(n)];
      const int grid_column = static_cast<int>(c) / n;
      if (shown.left > shown.right) shown.left = grid_column;
      shown.left = std::min(shown.left, grid_column);
      shown.right = std::max(shown.right, grid_column);
      tap.right = static_cast<std::uint16_t>(std::lround(128.0 * (p.x() - column)));
      tap.below = static_cast<std::uint16_t>(std::lround(128.0 * (p.y() - row)));
    }
  }
}

bool RectifiedLevel::update(const Level& level, const Mapping& mapping, double reach) {
  if (mapping.affine() || level.width < 2 || level.height < 2) return false;
  const auto same = [&](const Table& table) {
    return table.width == level.width && table.height == level.height && table.step_x == level.step_x &&
           table.step_y == level.step_y && table.mapping == mapping;
  };
  auto found = std::find_if(tables_.begin(), tables_.end(), same);
  if (found == tables_.end()) {
    if (tables_.size() >= most_tables) tables_.pop_back();
    tables_.insert(tables_.begin(), make_table(level, mapping));
    found = tables_.begin();
  }
  Table& table = *found;
  constexpr double tolerated = 0.5;  // level pixels
  if (!table.usable || table.change * table.scale * reach <= tolerated) return false;
  if (table.taps.empty()) add_taps(level, table);
  current_ = static_cast<std::size_t>(found - tables_.begin());

  const std::size_t pixels = static_cast<std::size_t>(table.grid_width) * static_cast<std::size_t>(table.grid_height);
  const auto samples = static_cast<std::size_t>(table.samples) * static_cast<std::size_t>(table.samples);
  memory_.resize(pixels + kernels::read_slack);
  const std::size_t seen = static_cast<std::size_t>(level.width) * static_cast<std::size_t>(level.height);
  std::size_t sum = 0;
  // First the mean, from every pixel of the level, which is cheaper than from the grid.
  for (int row = 0; row < level.height; ++row) {
    const std::uint8_t* p = level.row(row);
    for (int column = 0; column < level.width; ++column) sum += p[column];
  }
  const auto mean = static_cast<std::uint32_t>((sum + seen / 2) / seen);
  const bool packed = level.stride == level.width;
  const Tap* tap = table.taps.data();
  const auto shown = [&](const Tap& t) -> std::uint32_t {
    if (t.at < 0) return mean << 14U;
    const std::uint8_t* p = packed ? level.data + t.at : level.row(t.at / level.width) + t.at % level.width;
    const std::uint8_t* q = p + level.stride;
    const std::uint32_t top = 128U * p[0] + t.right * (static_cast<std::uint32_t>(p[1]) - p[0]);
    const std::uint32_t bottom = 128U * q[0] + t.right * (static_cast<std::uint32_t>(q[1]) - q[0]);
    return 128U * top + t.below * (bottom - top);
  };
  if (samples == 1) {
    for (std::size_t i = 0; i < pixels; ++i) {
      memory_[i] = static_cast<std::uint8_t>((shown(tap[i]) + (1U << 13U)) >> 14U);
    }
  } else {
    for (std::size_t i = 0; i < pixels; ++i) {
      std::uint32_t total = 0;
      for (std::size_t s = 0; s < samples; ++s) total += (shown(*tap++) + (1U << 5U)) >> 6U;
      memory_[i] = static_cast<std::uint8_t>(total / samples >> 8U);
    }
  }
  out_ = {};
  out_.data = memory_.data();
  out_.width = table.grid_width;
  out_.height = table.grid_height;
  out_.stride = table.grid_width;
  return true;
}

std::optional<Roi> RectifiedLevel::region(const Roi& frame) const {
  constexpr int steps = 24;
  const Table& table = tables_[current_];
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e300);
  Eigen::Vector2d high = -low;
  for (int j = 0; j <= steps; ++j) {
    for (int i = 0; i <= steps; ++i) {
      const Eigen::Vector2d at(frame.x - 0.5 + static_cast<double>(frame.width) * i / steps,
                               frame.y - 0.5 + static_cast<double>(frame.height) * j / steps);
      const Eigen::Vector2d plane = table.mapping.plane_from_image(table.mapping.image_from_frame(at));
      if (!plane.allFinite()) continue;
      const Eigen::Vector2d on_grid = table.grid_mapping.image_from_plane(plane);
      low = low.cwiseMin(on_grid);
      high = high.cwiseMax(on_grid);
    }
  }
  // One pixel more for what lies between the points.
  low = (low - Eigen::Vector2d::Ones()).cwiseMax(-1e6).cwiseMin(1e6);
  high = (high + Eigen::Vector2d::Ones()).cwiseMax(-1e6).cwiseMin(1e6);
  if (!(low.x() < high.x() && low.y() < high.y())) return std::nullopt;
  const int left = static_cast<int>(std::floor(low.x()));
  const int top = static_cast<int>(std::floor(low.y()));
  return Roi{left, top, static_cast<int>(std::ceil(high.x())) - left + 1,
             static_cast<int>(std::ceil(high.y())) - top + 1};
}

}  // namespace vsfind
