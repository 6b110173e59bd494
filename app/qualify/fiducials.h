#pragma once
/// @file
/// Fiducial squares, measured without the pattern finder: a line fitted to each side, the lines intersected to corners,
/// the corners averaged to a centre, the centres to one position and one angle.

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "app/qualify/square_finder.h"

namespace vsfind {

/// One square, plane units.
struct MeasuredSquare {
  Eigen::Vector2d centre{0.0, 0.0};
  std::vector<Eigen::Vector2d> corners;  ///< four
  double sigma = 0.0;                    ///< standard deviation of the centre per axis, from the fits' residuals
};

/// Fits the four sides. Nothing where one of them cannot be fitted.
[[nodiscard]] std::optional<MeasuredSquare> measure_square(const ImageView& image, const Mapping& mapping,
                                                           const RoughSquare& rough);

/// All squares of one picture as one body.
struct FiducialPose {
  Eigen::Vector2d centre{0.0, 0.0};  ///< mean of the squares' centres, plane units
  double angle_deg = 0.0;            ///< from the first picture measured, least squares over the centres
  double sigma = 0.0;                ///< of the centre, per axis
  double sigma_angle_deg = 0.0;
};

/// Follows the squares from picture to picture. They may move by half their side and turn by some 15 degrees between
/// two pictures.
class FiducialTracker {
 public:
  explicit FiducialTracker(std::vector<RoughSquare> start) : last_(std::move(start)) {}

  /// Nothing where one of the squares is not found; the next picture is then compared with the last good one.
  [[nodiscard]] std::optional<FiducialPose> measure(const ImageView& image, const Mapping& mapping);

  /// The squares where they were last seen, pixels.
  [[nodiscard]] const std::vector<RoughSquare>& squares() const { return last_; }

 private:
  std::vector<RoughSquare> last_;
  std::vector<Eigen::Vector2d> first_;  ///< centres in the first picture, from their mean
};

}  // namespace vsfind
