#pragma once
/// @file
/// What else looks like a trained pattern: other places of its training scene, the scenes it must be told from, and
/// the pattern itself turned. Measured with the search's own points, down to full resolution.

#include <string>
#include <vector>

#include "finder/pattern.h"
#include "finder/training_scene.h"
#include "finder/undetermined.h"

namespace vsfind {

/// A scene that must not be taken for the pattern; the pyramid's picture must outlive it.
struct OtherScene {
  ImageView image;  ///< or its edges
  Pyramid* pyramid = nullptr;
};

struct Impostor {
  double score = 0.0;  ///< normalized correlation over all of the pattern, as the search would report it
  int scene = -1;      ///< index of the other scene; −1: the training scene
  /// From the pattern to it: of the middle of the ROI, pattern pixels along the axes of the plane, and degrees. In
  /// other scenes of no meaning.
  Eigen::Vector2d shift{0.0, 0.0};
  double turn_deg = 0.0;
  Eigen::Vector2d image{0.0, 0.0};  ///< the middle of the ROI there, pixels of the scene's picture
};

/// Best first but for the first few as good. The pattern needs all its point sets and its image.
[[nodiscard]] std::vector<Impostor> find_impostors(TrainingScene& scene, const Pattern& pattern,
                                                   const std::vector<OtherScene>& others);

/// The best one in words, "turned by 90 degrees"; empty where there is none.
[[nodiscard]] std::string describe(const Impostor& impostor, const Pattern& pattern);

/// A sentence for each that could be taken for the pattern: turned copies, periods and their directions, other things.
/// Not for what is undetermined anyway.
[[nodiscard]] std::vector<std::string> warnings_of(const std::vector<Impostor>& impostors, const Pattern& pattern,
                                                   const Undetermined& known);

}  // namespace vsfind
