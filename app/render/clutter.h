#pragma once
/// @file
/// What makes a scene hard: things that look like the pattern's parts, things that hide it, other grey levels.

#include <optional>
#include <vector>

#include "app/render/random.h"
#include "app/render/scene.h"

namespace vsfind::render {

/// A smooth closed curve around (0,0) of about the given radius.
[[nodiscard]] Contour random_blob(Random& random, double radius);
/// A polygon of 3 to 8 corners around (0,0) that every ray from there meets once.
[[nodiscard]] Contour random_star(Random& random, double radius);

struct Clutter {
  int count = 25;
  double smallest = 12.0;  ///< sizes, pixels
  double largest = 90.0;
  std::vector<double> greys{40.0, 200.0, 120.0};  ///< each used with ±15 levels of chance
  double decoys =
      0.0;  ///< part of the shapes that are nested squares or plates with blobs, like the patterns' own parts
};

/// Adds random shapes all over the scene.
void add_clutter(Scene& scene, Random& random, const Clutter& clutter);

/// Textured things over a drawing, in its coordinates, that hide the given part (0 … 0.9) of its box to within 0.01.
[[nodiscard]] Drawing occluders(Random& random, const Drawing& drawing, double part);

/// The drawing with grey levels given anew at random, in any order (bright may become dark and dark stay so), shapes
/// telling themselves from what lies beneath by 35 levels at least, and `features` new things built up inside.
[[nodiscard]] Drawing remapped(Random& random, const Drawing& drawing, double background, int features);

/// A place for the item such that the given part of its box lies outside the picture (0: inside by a margin of 2
/// pixels); the angle is kept. Empty if chance found none.
[[nodiscard]] std::optional<Pose> random_place(Random& random, const Scene& scene, const Item& item, double outside);

}  // namespace vsfind::render
