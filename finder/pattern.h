#pragma once
/// @file
/// A trained pattern: what the search needs, and what a person wants to see of it. Read-only after training.

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "finder/pose.h"

namespace vsfind {

/// A point of the pattern that takes part in the correlation at one level of the pyramid.
struct PatternPoint {
  double x = 0.0;  ///< pattern pixels of full resolution, from the origin
  double y = 0.0;
  float value = 0.0F;       ///< grey value (or edge strength) there, 0 … 255
  float gradient_x = 0.0F;  ///< of the value, per pattern pixel of full resolution
  float gradient_y = 0.0F;
  float laplacian = 0.0F;  ///< of the value, per square pattern pixel; 0 where it is not used
  float stretch = 0.0F;  ///< ∂²/∂x² − ∂²/∂y², likewise; not kept in model files, PreparedPattern finds it anew
  float shear = 0.0F;  ///< 2·∂²/∂x∂y
};

/// What a point set is for.
enum class PointUse : std::uint8_t {
  search,   ///< exhaustive search at the top level
  follow,   ///< following candidates down
  refine,   ///< the sub-pixel pose at full resolution
  outline,  ///< the same, on the pattern's outermost edges: trusted only where they agree with the refine points, since
            ///< what lies around the pattern may change
  verify,   ///< the score of the final pose
};
[[nodiscard]] constexpr const char* name(PointUse use) {
  return use == PointUse::search    ? "search"
         : use == PointUse::follow  ? "follow"
         : use == PointUse::refine  ? "refine"
         : use == PointUse::outline ? "outline"
                                    : "verify";
}

/// The points used at one level. Level 0 is full resolution, each further one half of it.
struct PointSet {
  int level = 0;
  PointUse use = PointUse::follow;
  std::vector<PatternPoint> points;
};

/// A rectangular picture of the pattern, in a square grid of pattern pixels.
struct PatternImage {
  int width = 0;
  int height = 0;
  double origin_x = 0.0;  ///< the origin, in this picture's pixel coordinates
  double origin_y = 0.0;
  std::vector<std::uint16_t> grey;  ///< row by row, `width`·`height`, scaled to 16 bits: 255 in 8 bits is 65280 here
  std::vector<std::uint8_t> mask;   ///< 255 part of the pattern, 128 around it but seen in training, 0 not seen
};

/// What training measured about the pattern.
struct TrainReport {
  double training_ms = 0.0;
  /// Best score of anything but the pattern: in the training and `against` scenes, and of the pattern itself turned.
  double impostor_score = 0.0;
  std::string impostor;      ///< where that was, in words: "turned by 90 degrees"; empty where nothing is alike
  double noise_sigma = 0.0;  ///< grey levels (of 255), estimated from the training image
  double sigma_x = 0.0;      ///< expected standard deviations at an image noise of 2 grey levels (of 255)
  double sigma_y = 0.0;
  double sigma_angle_deg = 0.0;
  std::vector<std::string> warnings;  ///< plain sentences that name the direction that cannot be told
};

/// The weakest edge that may be asked for, grey levels (of 255) per pixel: less than half a step of 8 bits makes, and
/// far from where t⁴ is lost in single precision.
inline constexpr double least_edge_threshold = 0.01;

/// A trained pattern. Made by train() or load_model(); the fields are for reading.
struct Pattern {
  std::string name;
  std::string unit = "px";    ///< of plane coordinates when trained
  double pitch = 1.0;         ///< plane units per pattern pixel
  double pixel_aspect = 1.0;  ///< of the training image, for the record
  bool from_field = false;    ///< trained on a single field: half of the lines
  double width = 0.0;         ///< of the ROI, pattern pixels
  double height = 0.0;
  double left =
      0.0;  ///< of the ROI's outer edge from the origin, pattern pixels (so left is −width/2 for a centred origin)
  double top = 0.0;
  Range angle_deg{0.0, 0.0};  ///< the ranges trained for
  Range scale_x{1.0, 1.0};
  Range scale_y{1.0, 1.0};
  bool common_scale = false;  ///< one scale for both axes; then scale_y repeats scale_x
  int accuracy = 30;
  bool edges = false;           ///< gradients are matched instead of grey values
  double edge_threshold = 0.0;  ///< grey levels (of 255) per pixel, where `edges`
  bool spread = false;
  Polarity polarity = Polarity::same;

  int top_level = 0;            ///< level of the exhaustive search
  double angle_step_deg = 0.0;  ///< of the coarse grid; 0 where the angle is not searched
  double scale_step = 0.0;      ///< ratio of neighbouring coarse scales minus 1; 0 where not searched
  std::vector<PointSet> sets;
  PatternImage image;
  TrainReport report;
};

}  // namespace vsfind
