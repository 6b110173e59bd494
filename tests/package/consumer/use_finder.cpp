// Learns a pattern from a picture computed here, and finds it where it was moved to.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <vector>

#include "acquisition/image_view.h"
#include "calibration/mapping.h"
#include "finder/search.h"
#include "finder/train.h"

namespace {

constexpr int width = 320;
constexpr int height = 240;

struct Blob {
  double x, y, radius, brightness;
};

// Round spots around the part's centre; the radius is that of their Gaussian profile.
constexpr std::array<Blob, 7> part{{{-22, -18, 5, 120},
                                    {14, -24, 7, 90},
                                    {24, 8, 4, 130},
                                    {-8, 2, 9, 80},
                                    {-26, 20, 6, 110},
                                    {8, 24, 5, -40},
                                    {2, -10, 3, 100}}};

std::vector<std::uint8_t> scene(double centre_x, double centre_y) {
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(width) * height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      double grey = 60.0 + 0.05 * x;
      for (const Blob& blob : part) {
        const double dx = (x - centre_x - blob.x) / blob.radius;
        const double dy = (y - centre_y - blob.y) / blob.radius;
        grey += blob.brightness * std::exp(-0.5 * (dx * dx + dy * dy));
      }
      pixels[static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x)] =
          static_cast<std::uint8_t>(std::lround(std::fmin(255.0, std::fmax(0.0, grey))));
    }
  }
  return pixels;
}

vsfind::ImageView view(const std::vector<std::uint8_t>& pixels) {
  return {reinterpret_cast<const std::byte*>(pixels.data()), width, height, width, 8};
}

}  // namespace

int main() {
  const auto training = scene(150.0, 120.0);
  vsfind::TrainOptions what;
  what.roi = {110, 80, 81, 81};  // its centre, the pattern's origin, is (150, 120)
  const auto pattern = std::make_shared<const vsfind::Pattern>(vsfind::train(view(training), vsfind::Mapping(), what));

  vsfind::Finder finder({pattern}, vsfind::SearchOptions());
  const double x = 181.25;
  const double y = 97.5;
  const auto moved = scene(x, y);
  const auto& matches = finder.find(view(moved), vsfind::Mapping()).at(0).matches;
  if (matches.size() != 1) {
    std::fprintf(stderr, "%zu found instead of 1\n", matches.size());
    return 1;
  }
  const vsfind::Pose& pose = matches[0].pose;
  std::printf("found at %.3f %.3f, score %.3f\n", pose.x, pose.y, matches[0].score);
  if (std::hypot(pose.x - x, pose.y - y) > 0.05 || matches[0].score < 0.9) {
    std::fprintf(stderr, "expected %.3f %.3f within 0.05 px, score 0.9 or more\n", x, y);
    return 1;
  }
  const std::vector<std::uint8_t> blank(training.size(), 90);
  if (!finder.find(view(blank), vsfind::Mapping()).at(0).matches.empty()) {
    std::fprintf(stderr, "found in a blank picture\n");
    return 1;
  }
  return 0;
}
