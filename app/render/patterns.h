#pragma once
/// @file
/// The parts that are looked for, as drawings around (0,0).

#include <cstdint>

#include "app/render/scene.h"

namespace vsfind::render {

[[nodiscard]] Contour rectangle(double left, double top, double right, double bottom);
/// A circle as a polygon of the same area; its corners stay within 0.0001 of the circle. `reverse` makes a hole.
[[nodiscard]] Contour circle(const Eigen::Vector2d& centre, double radius, bool reverse = false);
/// The same contour moved.
[[nodiscard]] Contour moved(Contour contour, const Eigen::Vector2d& by);
/// Turned about (0,0).
[[nodiscard]] Contour turned(Contour contour, double angle_deg);

/// Concentric squares, dark and light in turn, the outermost `size` wide, all rings `ring` wide.
[[nodiscard]] Drawing bullseye(double size = 191.0, double ring = 20.0, double dark = 40.0, double light = 200.0);
[[nodiscard]] Drawing disc(double diameter = 100.0, double grey = 40.0);
[[nodiscard]] Drawing ring(double outer = 100.0, double inner = 50.0, double grey = 40.0);
/// Irregular artwork without any symmetry: a plate with blobs and polygons of several grey levels on it.
[[nodiscard]] Drawing artwork(std::uint64_t seed = 1, double width = 150.0, double height = 130.0);
[[nodiscard]] Drawing cross(double size = 100.0, double bar = 24.0, double grey = 40.0);
/// An alignment mark as on wafers: a cross with a gap in a frame, two blocks that tell its orientation.
[[nodiscard]] Drawing wafer_mark(double size = 120.0);

/// The paper's target sheet: 640 × 480, light, a square in each corner; what is put in the middle is added to it.
[[nodiscard]] Scene target_sheet(double light = 200.0, double dark = 40.0);

}  // namespace vsfind::render
