#pragma once
/// @file
/// The pose that fits pattern points to a picture best: iterated least squares over pose, gain and offset together.
///
/// Linearized on the pattern's side (its gradients, as in inverse-compositional alignment: Baker & Matthews 2004), so
/// that noise in the picture does not bias the slope. At pose p the picture reads I_i at point q_i; with the pattern's
/// value T_i and its derivatives j_i by the pose,
///     I_i ≈ g·T_i + o − g·j_i·dp
/// is linear in (g, o, g·dp): one small system of normal equations a step.

#include <Eigen/Core>
#include <vector>

#include "finder/points.h"
#include "finder/sampling.h"

namespace vsfind {

/// Which values of the pose may move.
struct Freedom {
  bool angle = false;
  bool scale_x = false;
  bool scale_y = false;
  bool common_scale = false;      ///< scale_x and scale_y move as one
  bool blur = false;              ///< a difference in sharpness is fitted too (first order), and not reported
  bool directional_blur = false;  ///< with blur: the difference may depend on the direction, as a slant makes it
  bool shading = false;  ///< gain and offset that change linearly over the pattern are fitted, and not reported
};

/// image = gain · pattern + offset.
struct GreyLine {
  double gain = 0.0;
  double offset = 0.0;
};

struct FitOptions {
  Freedom freedom;
  int iterations = 5;
  bool robust = true;  ///< points that disagree lose their weight (Tukey)
  bool settle = true;  ///< the last steps drop points that disagree by more than the others' spread (Tukey);
                       ///< else by more than a third of the pattern's contrast, which suits a rough pose
  Polarity polarity = Polarity::same;
  double step_tolerance = 0.0;  ///< stop when no point moves by more, level pixels
  double noise_floor = 0.5;     ///< residuals below this never count as disagreement, grey levels
  GreyLine start;              ///< to begin with; where its gain is 0, the one that suits the most points is looked for
  int first_iteration = 0;     ///< the steps count from here: from 2 on, disagreement is judged strictly at once
  bool at_start_only = false;  ///< one step, and nothing is read at the pose that it leads to
  bool covariance = false;     ///< whether it is wanted
  bool try_shading = false;    ///< whether FitResult::shaded_residual is wanted
  int trusted = 0;             ///< the first so many points set the scale of disagreement, and are alone in the first
                               ///< steps; 0: all points
};

struct FitResult {
  bool ok = false;    ///< false: too few points inside, or no structure under them
  double gain = 0.0;  ///< image = gain · pattern + offset; negative where bright and dark are exchanged
  double offset = 0.0;
  double residual = 0.0;         ///< robust standard deviation of the residuals, grey levels
  double shaded_residual = 0.0;  ///< what it would be with shading fitted, too (FitOptions::try_shading)
  double inside = 0.0;           ///< part of the points inside the picture
  double visible = 0.0;          ///< part of the points inside the picture and not hidden
  /// How much of the pattern is seen, 0 … 1: the part of the values' variance that lies in points that agree (within
  /// half the pattern's contrast, less the nearer to it), times the correlation of those points. Unlike the correlation
  /// of all points it is not spoilt by what hides some of them.
  double explained = 0.0;
  /// Of (a, b, angle, scale_x, scale_y) for independent residuals of 1 grey level; a, b: pattern pixels along the
  /// pattern's own axes.
  Eigen::Matrix<double, 5, 5> covariance = Eigen::Matrix<double, 5, 5>::Zero();
};

/// Scratch memory and the fit itself.
class PoseFit {
 public:
  /// Improves `pose`. On failure (`ok` false) the pose is as it was.
  FitResult fit(const PointArrays& points, const Projection& projection, const Reader& reader,
                const FitOptions& options, Pose& pose);

  /// Normalized correlation of the points with the picture at a pose, over the points inside; signed. `inside` is
  /// their part. 0 where fewer than four are inside or nothing varies.
  double correlation(const PointArrays& points, const Projection& projection, const Reader& reader, const Pose& pose,
                     double& inside);

  /// The same for the points as they were read last.
  [[nodiscard]] double correlation_as_read(const PointArrays& points, double& inside) const;

 private:
  using Line = GreyLine;
  /// Gain and offset that suit the most points as they were read last, whatever hides the others: the best of a few
  /// dozen pairs of points (random sample consensus; the pairs are always the same).
  [[nodiscard]] Line agreeing_line(const PointArrays& points, int trusted, Polarity polarity);
  void read_at(const PointArrays& points, const Projection& projection, const Reader& reader, const Pose& pose);
  void update_turn_column(const PointArrays& points, const Pose& pose);
  /// Robust standard deviation of the residuals nearer than `within`; negative where there are none.
  [[nodiscard]] float spread_of_residuals(int trusted, double within);
  /// The spread of the residuals were shading fitted as well, at the pose and with the weights of the last step.
  [[nodiscard]] double residual_with_shading(const PointArrays& points, const FitOptions& options, double within);
  /// How the pattern is seen: what is left of the picture after gain, offset, blur and shading, but not after a change
  /// of the pose.
  void judge_view(const PointArrays& points, FitResult& result) const;

  Places places_;
  std::vector<float> image_, inside_, weight_, target_, residual_, scratch_;
  std::vector<float> turn_column_, growth_column_;
  std::vector<float> judged_, judged_target_, judged_inside_;
};

}  // namespace vsfind
