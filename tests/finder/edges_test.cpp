/// Pictures of edges hold numbers, whatever is asked of them.
#include "finder/edges.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <vector>

namespace vsfind {
namespace {

constexpr int width = 24;
constexpr int height = 20;

/// Dark on the left, bright from column 12 on.
std::vector<std::byte> step() {
  std::vector<std::byte> pixels(static_cast<std::size_t>(width) * height, std::byte{20});
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (i % width >= 12) pixels[i] = std::byte{200};
  }
  return pixels;
}

TEST(EdgeImage, NothingIsAnEdgeWhereNothingChanges) {
  const std::vector<std::byte> pixels = step();
  EdgeImage edges;
  // Fourth powers of the last two are nothing in single precision: 0/0, which the sanitizer sees turned into a byte.
  for (const double threshold : {1.5, least_edge_threshold, 1e-12, 0.0}) {
    const ImageView view = edges.compute({pixels.data(), width, height, width, 8}, threshold);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const bool edge = x == 11 || x == 12;
        if (edge && y > 1 && y + 2 < height) {
          EXPECT_GE(view.at(x, y), 254) << threshold << ' ' << x << ' ' << y;
        }
        if (x < 10 || x > 13) {
          EXPECT_EQ(view.at(x, y), 0) << threshold << ' ' << x << ' ' << y;
        }
      }
    }
  }
}

TEST(EdgeImage, WhatIsFlatNeedsNoThreshold) {
  const std::vector<std::byte> pixels(static_cast<std::size_t>(width) * height, std::byte{77});
  EXPECT_GE(automatic_edge_threshold({pixels.data(), width, height, width, 8}, {0, 0, width, height}),
            least_edge_threshold);
}

}  // namespace
}  // namespace vsfind
