#pragma once
/// @file
/// How exactly a pattern's pose can be known at best from a picture's pixels, by anybody.

#include "acquisition/image_view.h"
#include "calibration/mapping.h"
#include "finder/pattern.h"

namespace vsfind {

/// Standard deviations, plane units and degrees.
struct PoseBound {
  double x = 0.0;
  double y = 0.0;
  double angle_deg = 0.0;  ///< 0 where the angle is not asked for
};

/// The Cramér-Rao bound: the inverse of the information that all pixels of the pattern, as far as it was taught, hold
/// about position, angle, gain and offset at once, for independent normal noise. Gradients come from the pictures
/// themselves by a seven-tap derivative; what the noise adds to their squares is taken off, and pictures are averaged.
class PoseBoundEstimator {
 public:
  /// `noise`: standard deviation of a pixel, grey levels of 255.
  void add(const ImageView& image, const Mapping& mapping, const Pattern& pattern, const Pose& pose, double noise);

  /// `with_angle`: the angle is unknown, too. All zero where nothing was added or the pattern leaves a direction open.
  [[nodiscard]] PoseBound bound(bool with_angle) const;

 private:
  Eigen::Matrix<double, 5, 5> information_ = Eigen::Matrix<double, 5, 5>::Zero();  ///< x, y, angle (rad), gain, offset
  int pictures_ = 0;
};

}  // namespace vsfind
