#pragma once
/// @file
/// Rendered scenes seen by a calibrated camera: pixels that are not square, a slanted plane, a lens that bends lines.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "app/render/scene.h"
#include "app/render/sensor.h"
#include "finder/search.h"
#include "finder/train.h"

namespace vsfind::measure {

/// A camera before a plane; frames of 640 × 480.
struct Camera {
  std::string name;
  Mapping mapping;         ///< of whole frames
  double unit = 1.0;       ///< plane units to a pixel, about, in the middle
  std::string plane_unit;  ///< their name
};

/// Pixels of 625-line video, 59:54.
[[nodiscard]] Camera pixel_aspect_camera();
/// Slanted by 35 degrees: the scale changes by 40% from the upper border to the lower. mm.
[[nodiscard]] Camera slanted_camera();
/// Slanted by 50 degrees before a shorter lens: the scale changes more than twofold.
[[nodiscard]] Camera steep_camera();
/// The camera at 35 degrees with a lens whose distortion reaches 5% of the picture's width in the corners.
[[nodiscard]] Camera slanted_lens_camera();
/// Straight above the plane, pixels as wide as those of the others in the middle: what mapping costs is told against
/// it.
[[nodiscard]] Camera straight_camera();

/// A pattern as trained from a whole frame of the camera.
struct CalibratedPattern {
  std::shared_ptr<const Pattern> pattern;
  render::Drawing drawing;
  Pose pose;               ///< of the drawing in the training picture
  Eigen::Vector2d origin;  ///< plane
};

/// `drawing` is in pixels of the picture's middle; `at`: frame pixel at which it lies; searched later at `angle`
/// degrees.
[[nodiscard]] CalibratedPattern train_through(const Camera& camera, const render::Drawing& drawing,
                                              const Eigen::Vector2d& at, const Range& angle, std::uint64_t seed,
                                              double noise = 2.0);

struct CalibratedShot {
  render::Picture picture;
  Mapping mapping;  ///< of the picture's lines
  Pose truth;       ///< what the finder must answer
};

struct CalibratedRecipe {
  double angle_limit = 60.0;  ///< degrees to either side
  int clutter = 20;
  Field field = Field::frame;
  double noise = 2.0;
};

/// The pattern anywhere in the picture at any angle, all of it given by the seed.
[[nodiscard]] CalibratedShot shot_through(const Camera& camera, const CalibratedPattern& pattern,
                                          const CalibratedRecipe& recipe, std::uint64_t seed);

/// The error of an answer in pattern pixels and degrees.
struct CalibratedError {
  double x = 0.0;
  double y = 0.0;
  double angle_deg = 0.0;
};
[[nodiscard]] CalibratedError error_of(const Match& match, const CalibratedShot& shot, const Pattern& pattern);

}  // namespace vsfind::measure
