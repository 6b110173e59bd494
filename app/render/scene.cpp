#include "app/render/scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/render/coverage.h"

namespace vsfind::render {
namespace {

/// Integral from minus infinity of a Gaussian of `sigma` convolved with the unit box, at t.
double step_response(double t, double sigma) {
  if (sigma <= 0.0) return std::clamp(t + 0.5, 0.0, 1.0);
  // The second integral of a Gaussian: ∫Φ(u/σ)du = u·Φ(u/σ) + σ·φ(u/σ).
  const auto ramp = [&](double u) {
    const double z = u / sigma;
    const double phi = std::exp(-0.5 * z * z) / std::sqrt(2.0 * std::numbers::pi);
    return u * 0.5 * std::erfc(-z / std::numbers::sqrt2) + sigma * phi;
  };
  return ramp(t + 0.5) - ramp(t - 0.5);
}

/// The response of pixels to a step at a cell boundary, for all places of the boundary within a pixel.
struct StepTable {
  int radius = 0;                           ///< pixels on either side that see a part of the step
  std::vector<std::vector<double>> growth;  ///< by boundary within the pixel: from pixel to pixel, −radius … radius + 1
};

StepTable make_steps(double sigma, int per_pixel) {
  StepTable table;
  table.radius = static_cast<int>(std::ceil(0.5 + 5.0 * sigma));
  for (int cell = 0; cell < per_pixel; ++cell) {
    const double boundary = static_cast<double>(cell) / per_pixel - 0.5;
    std::vector<double> row;
    double before = 0.0;
    for (int k = -table.radius; k <= table.radius + 1; ++k) {
      const double value = k <= table.radius ? step_response(k - boundary, sigma) : 1.0;
      row.push_back(value - before);
      before = value;
    }
    table.growth.push_back(std::move(row));
  }
  return table;
}

/// One row of cells blurred and integrated over pixels along x. The grid begins `radius` pixels left of pixel 0.
void filter_row(const std::vector<float>& cells, int per_pixel, const StepTable& table, int width,
                std::vector<double>& growth, float* out) {
  const auto radius = static_cast<std::size_t>(table.radius);
  const auto n = static_cast<std::size_t>(per_pixel);
  // growth[q] becomes the difference of pixel q − 2·radius from the one before it.
  growth.assign(static_cast<std::size_t>(width) + 4 * radius + 2, 0.0);
  for (std::size_t i = 1; i < cells.size(); ++i) {
    if (cells[i] == cells[i - 1]) continue;
    const double step = static_cast<double>(cells[i]) - static_cast<double>(cells[i - 1]);
    const std::vector<double>& response = table.growth[i % n];
    double* target = growth.data() + i / n;
    for (std::size_t k = 0; k < response.size(); ++k) target[k] += step * response[k];
  }
  auto sum = static_cast<double>(cells.front());
  for (std::size_t q = 0; q < 2 * radius; ++q) sum += growth[q];
  for (std::size_t x = 0; x < static_cast<std::size_t>(width); ++x) {
    sum += growth[x + 2 * radius];
    out[x] = static_cast<float>(sum);
  }
}

/// The item's shape in frame pixels. Straight lines stay straight unless a lens bends them: then they are subdivided.
std::vector<Contour> frame_contours(const Scene& scene, const Item& item, const Shape& shape) {
  std::vector<Contour> result;
  for (const Contour& contour : shape.contours) {
    Contour mapped;
    for (std::size_t i = 0; i < contour.size(); ++i) {
      mapped.push_back(frame_from_drawing(scene, item, contour[i]));
      if (!scene.frame_from_plane) continue;
      const Eigen::Vector2d& next = contour[(i + 1) % contour.size()];
      const int parts = static_cast<int>(std::ceil((next - contour[i]).norm() / 2.0));
      for (int k = 1; k < parts; ++k) {
        const double t = static_cast<double>(k) / parts;
        mapped.push_back(frame_from_drawing(scene, item, contour[i] * (1.0 - t) + next * t));
      }
    }
    result.push_back(std::move(mapped));
  }
  return result;
}

}  // namespace

Eigen::Vector2d frame_from_drawing(const Scene& scene, const Item& item, const Eigen::Vector2d& point) {
  const Eigen::Vector2d plane = plane_from_pattern(item.pose, point);
  return scene.frame_from_plane ? scene.frame_from_plane(plane) : plane;
}

Exposure expose(const Scene& scene, double blur_sigma, Field lines, int cells_per_pixel) {
  const bool sharp = blur_sigma > 0.0 && blur_sigma < 0.6;
  const int per_pixel = cells_per_pixel > 0 ? cells_per_pixel : sharp ? 16 : blur_sigma < 4.0 ? 8 : 4;
  // The cells are boxes, and stay boxes when the Gaussian runs over them: two boxes' variance is there already.
  const double cell_variance = 2.0 / (12.0 * per_pixel * per_pixel);
  const double variance = blur_sigma * blur_sigma - cell_variance;
  const StepTable table = make_steps(variance > 0.0 ? std::sqrt(variance) : 0.0, per_pixel);
  const int radius = table.radius;

  CellGrid grid;
  grid.per_pixel = per_pixel;
  grid.left = -radius;
  grid.top = -radius;
  grid.columns = (scene.width + 2 * radius) * per_pixel;
  grid.rows = (scene.height + 2 * radius) * per_pixel;
  std::vector<ShapeCoverage> shapes;
  for (const Item& item : scene.items) {
    for (const Shape& shape : item.drawing.shapes) {
      shapes.emplace_back(frame_contours(scene, item, shape), shape.grey, grid);
    }
  }

  // Along x, row of cells by row of cells.
  const auto width = static_cast<std::size_t>(scene.width);
  std::vector<float> filtered(static_cast<std::size_t>(grid.rows) * width);
  std::vector<float> cells(static_cast<std::size_t>(grid.columns));
  std::vector<float> scratch(cells.size() + 3, 0.0F);
  std::vector<double> work;
  for (int row = 0; row < grid.rows; ++row) {
    std::fill(cells.begin(), cells.end(), static_cast<float>(scene.background));
    for (const ShapeCoverage& shape : shapes) shape.paint(row, cells, scratch);
    filter_row(cells, per_pixel, table, scene.width, work, filtered.data() + static_cast<std::size_t>(row) * width);
  }

  // Along y: the weight of a cell is the difference of the responses to the steps at its two ends.
  std::vector<float> weights;
  for (int k = -radius; k <= radius; ++k) {
    for (int cell = 0; cell < per_pixel; ++cell) {
      const double begin = k - 0.5 + static_cast<double>(cell) / per_pixel;
      const double sigma = variance > 0.0 ? std::sqrt(variance) : 0.0;
      weights.push_back(
          static_cast<float>(step_response(-begin, sigma) - step_response(-begin - 1.0 / per_pixel, sigma)));
    }
  }
  Exposure result;
  result.width = scene.width;
  const int step = line_step(lines);
  result.height = lines == Field::top      ? (scene.height + 1) / 2
                  : lines == Field::bottom ? scene.height / 2
                                           : scene.height;
  result.grey.assign(static_cast<std::size_t>(result.height) * width, 0.0F);
  std::vector<float> sum(width);
  for (int y = 0; y < result.height; ++y) {
    std::fill(sum.begin(), sum.end(), 0.0F);
    const int frame_row = first_line(lines) + step * y;
    float total = 0.0F;
    for (std::size_t k = 0; k < weights.size(); ++k) {
      const float weight = weights[k];
      if (weight == 0.0F) continue;
      total += weight;
      const float* row = filtered.data() + (static_cast<std::size_t>(frame_row * per_pixel) + k) * width;
      for (std::size_t x = 0; x < width; ++x) sum[x] += weight * row[x];
    }
    float* out = result.grey.data() + static_cast<std::size_t>(y) * width;
    for (std::size_t x = 0; x < width; ++x) out[x] = sum[x] / total;
  }
  return result;
}

}  // namespace vsfind::render
