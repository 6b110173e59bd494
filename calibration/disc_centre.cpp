#include "calibration/disc_centre.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace vsfind {
namespace {

struct Pixel {
  double x;
  double y;
  double grey;
};

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

std::optional<Disc> measure_disc(const ImageView& image, Field field, const Eigen::Vector2d& guess, double reach) {
  const int first = first_line(field);
  const int step = line_step(field);
  const auto x0 = static_cast<int>(std::ceil(guess.x() - reach));
  const auto x1 = static_cast<int>(std::floor(guess.x() + reach));
  const auto row0 = static_cast<int>(std::ceil((guess.y() - reach - first) / step));
  const auto row1 = static_cast<int>(std::floor((guess.y() + reach - first) / step));
  if (x0 < 0 || x1 >= image.width || row0 < 0 || row1 >= image.height || x1 - x0 < 4 || row1 - row0 < 3) return {};
  const int width = x1 - x0 + 1;
  const int height = row1 - row0 + 1;
  const auto pixel = [&](int i, int j) -> Pixel {
    return {static_cast<double>(x0 + i), static_cast<double>((row0 + j) * step + first),
            static_cast<double>(image.at(x0 + i, row0 + j))};
  };
  const auto inside = [&](const Pixel& p) {
    return (Eigen::Vector2d(p.x, p.y) - guess).squaredNorm() <= reach * reach;
  };

  // What surrounds the spot is seen on the rim, the spot's own grey in its middle.
  std::vector<double> rim, middle;
  for (int j = 0; j < height; ++j) {
    for (int i = 0; i < width; ++i) {
      const Pixel p = pixel(i, j);
      const double distance = (Eigen::Vector2d(p.x, p.y) - guess).norm();
      if (distance <= reach && distance > reach - 1.5 * step) rim.push_back(p.grey);
      if (distance <= std::max(1.0 * step, 0.2 * reach)) middle.push_back(p.grey);
    }
  }
  if (rim.empty() || middle.empty()) return {};
  double ground = median(rim);
  double spot = median(middle);
  if (!(std::abs(spot - ground) > 0.02 * image.white())) return {};

  // The spot with a margin for its blurred edge; noise outside has no lever there.
  constexpr int margin = 3;
  std::vector<char> mask(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0);
  std::vector<double> outside, core;
  for (int j = 0; j < height; ++j) {
    for (int i = 0; i < width; ++i) {
      const Pixel p = pixel(i, j);
      if (!inside(p) || !((p.grey - ground) / (spot - ground) > 0.5)) continue;
      for (int v = std::max(0, j - margin); v <= std::min(height - 1, j + margin); ++v) {
        for (int u = std::max(0, i - margin); u <= std::min(width - 1, i + margin); ++u) {
          mask[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u)] = 1;
        }
      }
    }
  }
  for (int j = 0; j < height; ++j) {
    for (int i = 0; i < width; ++i) {
      const Pixel p = pixel(i, j);
      if (!inside(p)) continue;
      if (mask[static_cast<std::size_t>(j) * static_cast<std::size_t>(width) + static_cast<std::size_t>(i)] == 0) {
        outside.push_back(p.grey);
      } else if ((p.grey - ground) / (spot - ground) > 0.9) {
        core.push_back(p.grey);
      }
    }
  }
  if (outside.size() > 8) ground = median(outside);
  if (core.size() > 4) spot = median(core);
  double sum = 0.0;
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  for (int j = 0; j < height; ++j) {
    for (int i = 0; i < width; ++i) {
      const Pixel p = pixel(i, j);
      if (mask[static_cast<std::size_t>(j) * static_cast<std::size_t>(width) + static_cast<std::size_t>(i)] == 0)
        continue;
      if (!inside(p)) continue;
      const double part = (p.grey - ground) / (spot - ground);
      sum += part;
      moment += part * Eigen::Vector2d(p.x, p.y);
    }
  }
  if (!(sum > 3.0)) return {};
  const Disc disc{moment / sum, sum * step};
  if (!((disc.centre - guess).norm() < 0.5 * reach)) return {};
  return disc;
}

}  // namespace vsfind
