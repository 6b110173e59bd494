#pragma once
/// @file
/// The sub-pixel pose from the picture's own pixels: in a single field, where scales are searched, and where pixels are
/// not square.
///
/// A field's lines lie twice as far apart as the frame's, and each is as sharp as a frame's line: between them the
/// picture cannot be interpolated. The pattern can, where it was trained on a whole frame. So the roles are exchanged:
/// the picture is taken at its own pixels, and the pattern is read, through a spline, at the places where they fall. In
/// a whole frame this uses some five times as many pixels as there are points.

#include <cstdint>
#include <vector>

#include "finder/fit.h"
#include "finder/pattern_spline.h"

namespace vsfind {

/// Keeps its scratch memory between pictures.
class FieldFit {
 public:
  /// Whether it is the better way at a pose: where the lines lie further apart, in the pattern, than they may for
  /// reading between them.
  [[nodiscard]] static bool pays(const Projection& projection, const Pose& pose);

  /// Improves `pose`, which must be right within half a pixel. `around`: pattern points whose neighbouring pixels are
  /// used, the first `options.trusted` of them trusted. `image` is what `projection`'s level 0 shows. The residuals of
  /// the points fitted are independent, so FitResult::covariance holds as it is.
  FitResult fit(const PatternSpline& spline, const PointArrays& around, const ImageView& image,
                const Projection& projection, const FitOptions& options, PoseFit& fit, Pose& pose);

 private:
  /// The pixels next to the points, each once: where they lie, in the pattern (at `pose`) and in the picture.
  void gather(const PointArrays& around, const ImageView& image, const Projection& projection, int trusted,
              const Pose& pose);
  /// Brings the pattern's places of the pixels from where they are, nearly, to where they project to.
  void settle(const Projection& projection, const Pose& pose, const Eigen::Matrix2d& pattern_from_level);
  /// Pattern values at the pixels' places at `now`; which were found at `gathered`.
  void read_pattern(const PatternSpline& spline, double pitch, const Pose& gathered, const Pose& now, bool anew);

  struct Pixel {
    std::int32_t column = 0;
    std::int32_t row = 0;
    float grey = 0.0F;
  };
  std::vector<double> u_, v_;
  std::vector<std::uint8_t> taken_;  ///< all 0 between calls
  std::vector<Pixel> pixels_;
  int trusted_ = 0;                 ///< the first so many pixels
  std::vector<double> x_, y_;       ///< pattern pixels at the pose of gather()
  std::vector<PatternPoint> read_;  ///< the pattern there, as last read from the spline
  std::vector<std::uint8_t> seen_;  ///< whether the pattern reaches there
  std::vector<PatternPoint> points_;
  std::vector<float> greys_;  ///< of points_
  int trusted_points_ = 0;
  PointArrays arrays_;
};

}  // namespace vsfind
