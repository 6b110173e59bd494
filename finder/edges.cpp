#include "finder/edges.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace vsfind {

namespace {

/// Gradient of a picture smoothed by [1 2 1]/4 both ways, grey levels (of 255) per pixel.
template <typename Pixel>
void gradient(const ImageView& image, double scale, std::vector<float>& lines, std::vector<float>& magnitude_squared) {
  const int w = image.width;
  const int h = image.height;
  const auto size = static_cast<std::size_t>(w) * static_cast<std::size_t>(h);
  magnitude_squared.assign(size, 0.0F);
  lines.resize(static_cast<std::size_t>(w) * 2);
  float* sums = lines.data();             // [1 2 1] along y
  float* differences = lines.data() + w;  // [-1 0 1] along y
  const auto norm = static_cast<float>(scale / 8.0);
  for (int y = 1; y + 1 < h; ++y) {
    const auto* a = reinterpret_cast<const Pixel*>(image.data + (y - 1) * image.stride);
    const auto* b = reinterpret_cast<const Pixel*>(image.data + y * image.stride);
    const auto* c = reinterpret_cast<const Pixel*>(image.data + (y + 1) * image.stride);
    for (int x = 0; x < w; ++x) {
      sums[x] = static_cast<float>(a[x] + 2 * b[x] + c[x]);
      differences[x] = static_cast<float>(c[x] - a[x]);
    }
    float* out = magnitude_squared.data() + static_cast<std::ptrdiff_t>(y) * w;
    for (int x = 1; x + 1 < w; ++x) {
      const float gx = (sums[x + 1] - sums[x - 1]) * norm;
      const float gy = (differences[x - 1] + 2.0F * differences[x] + differences[x + 1]) * norm;
      out[x] = gx * gx + gy * gy;
    }
  }
}

void gradient(const ImageView& image, std::vector<float>& lines, std::vector<float>& magnitude_squared) {
  if (image.bits > 8) {
    gradient<std::uint16_t>(image, 1.0 / std::ldexp(1.0, image.bits - 8), lines, magnitude_squared);
  } else {
    gradient<std::uint8_t>(image, 1.0, lines, magnitude_squared);
  }
}

}  // namespace

ImageView EdgeImage::compute(const ImageView& image, double threshold) {
  gradient(image, lines_, smooth_);
  const int w = image.width;
  const int h = image.height;
  edges_.resize(smooth_.size());
  const double t = std::max(threshold, least_edge_threshold);  // 0 would make nothing of where nothing changes
  const auto t4 = static_cast<float>(t * t * t * t);
  for (std::size_t i = 0; i < smooth_.size(); ++i) {
    const float g4 = smooth_[i] * smooth_[i];
    edges_[i] = static_cast<std::uint8_t>(255.0F * g4 / (g4 + t4));
  }
  // An edge pixel whose neighbours hold no edge is noise: it keeps no more than they have.
  cleaned_.assign(edges_.size(), 0);
  for (int y = 1; y + 1 < h; ++y) {
    const std::uint8_t* a = edges_.data() + static_cast<std::ptrdiff_t>(y - 1) * w;
    const std::uint8_t* b = a + w;
    const std::uint8_t* c = b + w;
    std::uint8_t* out = cleaned_.data() + static_cast<std::ptrdiff_t>(y) * w;
    for (int x = 1; x + 1 < w; ++x) {
      // The second strongest neighbour: a line of edge pixels has two.
      const std::uint8_t n[8] = {a[x - 1], a[x], a[x + 1], b[x - 1], b[x + 1], c[x - 1], c[x], c[x + 1]};
      std::uint8_t first = 0;
      std::uint8_t second = 0;
      for (const std::uint8_t value : n) {
        second = std::max(second, std::min(first, value));
        first = std::max(first, value);
      }
      out[x] = std::min(b[x], second);
    }
  }
  ImageView view;
  view.data = reinterpret_cast<const std::byte*>(cleaned_.data());
  view.width = w;
  view.height = h;
  view.stride = w;
  view.bits = 8;
  return view;
}

double automatic_edge_threshold(const ImageView& image, const Roi& roi) {
  std::vector<float> lines;
  std::vector<float> squared;
  gradient(image, lines, squared);
  std::vector<float> magnitudes;
  for (int y = std::max(1, roi.y); y < std::min(image.height - 1, roi.y + roi.height); ++y) {
    for (int x = std::max(1, roi.x); x < std::min(image.width - 1, roi.x + roi.width); ++x) {
      magnitudes.push_back(std::sqrt(
          squared[static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x)]));
    }
  }
  if (magnitudes.empty()) return 1.0;
  // Otsu on 256 bins up to the 99.5th percentile.
  std::vector<float> sorted = magnitudes;
  const auto high = sorted.begin() + static_cast<std::ptrdiff_t>(static_cast<double>(sorted.size() - 1) * 0.995);
  std::nth_element(sorted.begin(), high, sorted.end());
  const double top = std::max(1e-3, static_cast<double>(*high));
  std::array<double, 256> bins{};
  for (const float m : magnitudes)
    bins[static_cast<std::size_t>(std::min(255.0, static_cast<double>(m) / top * 255.0))] += 1.0;
  double total = 0.0;
  double moment = 0.0;
  for (std::size_t i = 0; i < bins.size(); ++i) {
    total += bins[i];
    moment += bins[i] * static_cast<double>(i);
  }
  double below = 0.0;
  double below_moment = 0.0;
  double best = -1.0;
  double cut = 0.0;
  for (std::size_t i = 0; i + 1 < bins.size(); ++i) {
    below += bins[i];
    below_moment += bins[i] * static_cast<double>(i);
    if (below == 0.0 || below == total) continue;
    const double difference = below_moment / below - (moment - below_moment) / (total - below);
    const double between = below * (total - below) * difference * difference;
    if (between > best) {
      best = between;
      cut = static_cast<double>(i) + 0.5;
    }
  }
  const double otsu = cut / 255.0 * top;
  // Magnitudes of pure noise follow a Rayleigh distribution, whose median is 1.18 times its scale.
  const auto middle = magnitudes.begin() + static_cast<std::ptrdiff_t>(magnitudes.size() / 2);
  std::nth_element(magnitudes.begin(), middle, magnitudes.end());
  const double noise = static_cast<double>(*middle) / 1.18;
  // Just above the noise: an edge counts the same however weak it has become.
  return std::max(1.5, std::min(4.0 * noise, otsu));
}

}  // namespace vsfind
