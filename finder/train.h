#pragma once
/// @file
/// Learning a pattern from one picture.

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/image_view.h"
#include "calibration/mapping.h"
#include "finder/pattern.h"

namespace vsfind {

/// What to learn, and how it will be searched. Checked once, by train().
struct TrainOptions {
  std::string name = "pattern";
  Roi roi;                                ///< in pixels of the training image
  std::optional<Eigen::Vector2d> origin;  ///< in pixels of the training image; else the centre of the ROI
  ImageView
      mask;  ///< 8 bits, as large as the ROI or as the training image; non-zero is part of the pattern; empty: all
  Range angle_deg{0.0, 0.0};  ///< within −360 … 360, at most 360 wide
  Range scale_x{1.0, 1.0};    ///< within 0.5 … 2
  Range scale_y{1.0, 1.0};
  bool common_scale = false;  ///< both axes alike: scale_y must equal scale_x
  int accuracy = 30;          ///< 1 … 100: how many points the final pose may use
  bool edges = false;
  std::optional<double> edge_threshold;  ///< grey levels (of 255) per pixel, least_edge_threshold … 255; else automatic
  Polarity polarity = Polarity::same;
  bool spread = false;
  std::vector<ImageView> against;  ///< further scenes whose content must not be taken for the pattern
  std::string unit = "px";         ///< of the mapping's plane
};

/// Learns the pattern inside the ROI. `mapping` takes pixels of `image` to the plane (its field says whether the image
/// is a single field). Throws UsageError where an option is out of its range or the pattern cannot work, naming why.
[[nodiscard]] Pattern train(const ImageView& image, const Mapping& mapping, const TrainOptions& options);

}  // namespace vsfind
