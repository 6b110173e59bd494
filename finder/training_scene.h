#pragma once
/// @file
/// The training picture with its pyramid, and the lattice of pattern pixels laid over it.

#include <Eigen/Core>
#include <vector>

#include "finder/points.h"
#include "finder/pyramid.h"
#include "finder/sampling.h"
#include "finder/train.h"

namespace vsfind {

/// What training reads from. The picture's memory must outlive it.
class TrainingScene {
 public:
  /// `image`: the picture itself, or its edges.
  TrainingScene(const ImageView& image, Mapping mapping, const TrainOptions& options, int levels);

  [[nodiscard]] const ImageView& image() const { return image_; }
  [[nodiscard]] const Mapping& mapping() const { return mapping_; }
  [[nodiscard]] Pyramid& pyramid() { return pyramid_; }
  [[nodiscard]] const HalvingPlan& plan() const { return plan_; }
  [[nodiscard]] double pitch() const { return pitch_; }
  [[nodiscard]] const Pose& pose() const { return pose_; }  ///< of the pattern in its own training picture
  [[nodiscard]] Projection projection(const Level& level) const { return {&mapping_, &level, pitch_}; }

  /// The ROI's outer edge from the origin, pattern pixels.
  [[nodiscard]] double left() const { return left_; }
  [[nodiscard]] double top() const { return top_; }
  [[nodiscard]] double width() const { return width_; }
  [[nodiscard]] double height() const { return height_; }

  /// Whether a pattern point (pattern pixels from the origin) and a square of ±reach around it belong to the pattern.
  [[nodiscard]] bool in_pattern(double x, double y, double reach) const;
  /// Pattern points every `step` pixels over the ROI, with a square of ±reach inside the pattern. With step 1 and plain
  /// pixels they fall on the pixels' centres.
  [[nodiscard]] std::vector<Eigen::Vector2d> lattice(double step, double reach) const;
  /// Reads through the Gaussian that training and search share.
  [[nodiscard]] GaussianReader gaussian() const;

 private:
  [[nodiscard]] bool masked_in(double x, double y) const;

  ImageView image_;
  Mapping mapping_;
  Roi roi_;
  ImageView mask_;
  HalvingPlan plan_;
  Pyramid pyramid_;
  double pitch_ = 1.0;
  Pose pose_;
  double left_ = 0.0;
  double top_ = 0.0;
  double width_ = 0.0;
  double height_ = 0.0;
};

/// Width of the reading kernel, pattern pixels.
inline constexpr double reading_sigma = 1.0;

/// Size of a picture's pixel in the plane, around an image point: (along x, along y).
[[nodiscard]] Eigen::Vector2d pixel_size(const Mapping& mapping, const Eigen::Vector2d& image);

/// The Gaussian reader for a picture: as wide in the plane as reading_sigma pattern pixels, within what 8 taps can do.
[[nodiscard]] GaussianReader gaussian_reader(const ImageView& image, const Mapping& mapping,
                                             const Eigen::Vector2d& image_point, double pitch, double scale);

}  // namespace vsfind
