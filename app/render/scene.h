#pragma once
/// @file
/// A scene of analytic shapes, and what a lens makes of it: every pose in it is known exactly.
///
/// Shapes are polygons (a disc is one of very many corners), drawn one over the other. A pixel is the exact area
/// integral over its square of the scene blurred by a Gaussian; see expose() for how far "exact" goes.
/// Coordinates are vsfind's: integers at pixel centres, x right, y down, grey levels 0 … 255 as real numbers.

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "acquisition/image_view.h"
#include "finder/pose.h"

namespace vsfind::render {

using Contour = std::vector<Eigen::Vector2d>;

/// A region of one grey level. A hole is a further contour that runs the other way round. No contour may cross itself
/// or another one of the same shape.
struct Shape {
  std::vector<Contour> contours;
  double grey = 0.0;
};

/// Shapes in drawing coordinates, later ones over earlier ones. The drawing's own point (0,0) is what a pose places.
struct Drawing {
  std::vector<Shape> shapes;
  double width = 0.0;  ///< of the box around (0,0) in which the drawing's own features lie
  double height = 0.0;
};

/// A drawing at a place, in plane coordinates.
struct Item {
  Drawing drawing;
  Pose pose;
};

struct Scene {
  int width = 640;
  int height = 480;
  double background = 200.0;
  std::vector<Item> items;  ///< later ones over earlier ones
  /// Lens, perspective, pixel aspect: frame pixels of a plane point. Empty: the plane is the frame.
  std::function<Eigen::Vector2d(const Eigen::Vector2d&)> frame_from_plane;
};

/// Real grey levels, row by row.
struct Exposure {
  int width = 0;
  int height = 0;
  std::vector<float> grey;
  [[nodiscard]] float at(int x, int y) const {
    return grey[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
  }
};

/// The scene through optics of a Gaussian blur of `blur_sigma` pixels (0 … 20), area-sampled at the pixels of the whole
/// frame or of one of its fields (then of half the rows).
///
/// Shapes are rasterized by their exact area in cells of 1/8 pixel (1/4 from a blur of 4 pixels on, 1/16 below 0.6);
/// Gaussian and pixel square are then integrated in closed form over the cells, the cells' own width taken off the
/// Gaussian's. Where no two outlines meet in one cell the result is exact for blur 0; else its positions are right to
/// 0.0001 pixel (measured by the tests of this folder). `cells_per_pixel`: another number of cells.
[[nodiscard]] Exposure expose(const Scene& scene, double blur_sigma, Field lines = Field::frame,
                              int cells_per_pixel = 0);

/// Frame pixels of a point of the item's drawing.
[[nodiscard]] Eigen::Vector2d frame_from_drawing(const Scene& scene, const Item& item, const Eigen::Vector2d& point);

}  // namespace vsfind::render
