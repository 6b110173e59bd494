#pragma once
/// @file
/// A picture of the edges in a picture: what is matched when grey values cannot be trusted.

#include <cstdint>
#include <vector>

#include "acquisition/image_view.h"
#include "finder/pattern.h"
#include "finder/pose.h"

namespace vsfind {

/// Edge strength as an 8-bit picture of the same size: gradient magnitude g pressed to 255·g⁴/(g⁴+t⁴), so that an edge
/// well above the threshold t counts the same whatever its contrast, on either side and of either direction; isolated
/// edge pixels are removed. Keeps its memory between pictures.
class EdgeImage {
 public:
  /// `threshold`: grey levels (of 255) per pixel, least_edge_threshold at the least. The view lives until the next
  /// call.
  ImageView compute(const ImageView& image, double threshold);

 private:
  std::vector<float> smooth_;
  std::vector<float> lines_;
  std::vector<std::uint8_t> edges_;
  std::vector<std::uint8_t> cleaned_;
};

/// A threshold that separates the significant edges inside the ROI from noise: four times the scale of the noise's
/// gradients (from their median), at most what Otsu's method says.
[[nodiscard]] double automatic_edge_threshold(const ImageView& image, const Roi& roi);

}  // namespace vsfind
