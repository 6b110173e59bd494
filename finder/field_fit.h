#pragma once
/// @file
/// The sub-pixel pose in a single field.
///
/// A field's lines lie twice as far apart as the frame's, and each is as sharp as a frame's line: between them the
/// picture cannot be interpolated. The pattern can, where it was trained on a whole frame. So the roles are exchanged:
/// the picture is taken at its own pixels, and the pattern is read, through a spline, at the places where they fall.

#include <vector>

#include "finder/fit.h"
#include "finder/pattern_spline.h"

namespace vsfind {

class FieldFit {
 public:
  /// Improves `pose`, which must be right within a pixel or so. `around`: pattern points whose nearest pixels are used,
  /// the first `options.trusted` of them trusted. `image` is what `projection`'s level 0 shows.
  FitResult fit(const PatternSpline& spline, const PointArrays& around, const ImageView& image,
                const Projection& projection, const FitOptions& options, PoseFit& fit, Pose& pose);

 private:
  struct Pixel {
    double u = 0.0;
    double v = 0.0;
    bool trusted = true;
  };
  std::vector<double> u_, v_;
  std::vector<Pixel> pixels_;
  std::vector<PatternPoint> points_;
};

}  // namespace vsfind
