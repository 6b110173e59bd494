#include "app/qualify/image_noise.h"

#include <cmath>
#include <vector>

namespace vsfind {

double image_noise(const ImageView& image) {
  if (image.width < 3 || image.height < 3) return 0.0;
  std::vector<double> responses;
  responses.reserve(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  const int white = static_cast<int>(image.white());
  for (int y = 1; y + 1 < image.height; ++y) {
    for (int x = 1; x + 1 < image.width; ++x) {
      const int centre = image.at(x, y);
      if (centre <= 0 || centre >= white) continue;
      const int corners =
          image.at(x - 1, y - 1) + image.at(x + 1, y - 1) + image.at(x - 1, y + 1) + image.at(x + 1, y + 1);
      const int sides = image.at(x, y - 1) + image.at(x - 1, y) + image.at(x + 1, y) + image.at(x, y + 1);
      responses.push_back(corners - 2 * sides + 4 * centre);
    }
  }
  // The mask's weights have a square sum of 36. What is left of a normal distribution within ±3 sigma has 0.9866 of
  // its standard deviation.
  constexpr double inside_three = 0.98658;
  double limit = 1e300;
  double sigma = 0.0;
  for (int round = 0; round < 30; ++round) {
    double squares = 0.0;
    double count = 0.0;
    for (const double r : responses) {
      if (std::abs(r) > limit) continue;
      squares += r * r;
      count += 1.0;
    }
    if (count == 0.0) return 0.0;
    const double found = std::sqrt(squares / count) / (round == 0 ? 1.0 : inside_three);
    const bool still = std::abs(found - sigma) < 1e-4 * found;
    sigma = found;
    if (still) break;
    limit = 3.0 * sigma;
  }
  return sigma / 6.0 * 255.0 / image.white();
}

}  // namespace vsfind
