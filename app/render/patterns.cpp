#include "app/render/patterns.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/render/clutter.h"
#include "app/render/random.h"

namespace vsfind::render {
namespace {

constexpr double degrees = std::numbers::pi / 180.0;

}  // namespace

Contour rectangle(double left, double top, double right, double bottom) {
  return {{left, top}, {right, top}, {right, bottom}, {left, bottom}};
}

Contour circle(const Eigen::Vector2d& centre, double radius, bool reverse) {
  const int corners = std::max(24, static_cast<int>(std::ceil(std::numbers::pi * std::sqrt(radius / 2e-4))));
  const double step = 2.0 * std::numbers::pi / corners;
  const double corner_radius = radius * std::sqrt(step / std::sin(step));  // the polygon's area is the circle's
  Contour contour;
  for (int i = 0; i < corners; ++i) {
    const double angle = (reverse ? -step : step) * i;
    contour.emplace_back(centre.x() + corner_radius * std::cos(angle), centre.y() + corner_radius * std::sin(angle));
  }
  return contour;
}

Contour moved(Contour contour, const Eigen::Vector2d& by) {
  for (Eigen::Vector2d& p : contour) p += by;
  return contour;
}

Contour turned(Contour contour, double angle_deg) {
  const double c = std::cos(angle_deg * degrees);
  const double s = std::sin(angle_deg * degrees);
  for (Eigen::Vector2d& p : contour) p = Eigen::Vector2d(c * p.x() - s * p.y(), s * p.x() + c * p.y());
  return contour;
}

Drawing bullseye(double size, double ring, double dark, double light) {
  Drawing drawing{{}, size, size};
  bool is_dark = true;
  for (double side = size; side > 0.25 * ring; side -= 2.0 * ring) {
    const double half = side / 2.0;
    drawing.shapes.push_back({{rectangle(-half, -half, half, half)}, is_dark ? dark : light});
    is_dark = !is_dark;
  }
  return drawing;
}

Drawing disc(double diameter, double grey) { return {{{{circle({0, 0}, diameter / 2.0)}, grey}}, diameter, diameter}; }

Drawing ring(double outer, double inner, double grey) {
  return {{{{circle({0, 0}, outer / 2.0), circle({0, 0}, inner / 2.0, true)}, grey}}, outer, outer};
}

Drawing artwork(std::uint64_t seed, double width, double height) {
  Random random(seed * 7919 + 17);
  Drawing drawing{{}, width, height};
  const double unit = std::min(width, height);
  // The plate, a little irregular, within the box.
  Contour plate;
  for (const auto& [u, v] : {std::pair{-1, -1}, {0, -1}, {1, -1}, {1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}}) {
    plate.emplace_back(u * width * random.uniform(0.38, 0.48), v * height * random.uniform(0.38, 0.48));
  }
  drawing.shapes.push_back({{plate}, 90.0});
  constexpr double greys[] = {30.0, 220.0, 150.0, 50.0, 190.0};
  std::vector<Eigen::Vector2d> centres;
  for (int i = 0; i < 9; ++i) {
    Eigen::Vector2d centre;
    // Parts placed early may leave no room for a later one: after many tries it may come nearer.
    int tries = 0;
    const auto close = [&](const Eigen::Vector2d& other) {
      return (other - centre).norm() < (tries < 500 ? 0.24 : 0.12) * unit;
    };
    do {
      ++tries;
      centre = {random.uniform(-0.36, 0.36) * width, random.uniform(-0.36, 0.36) * height};
    } while (tries < 1000 && std::any_of(centres.begin(), centres.end(), close));
    centres.push_back(centre);
    const double radius = unit * random.uniform(0.07, 0.14);
    Contour contour = random.chance(0.5) ? random_blob(random, radius) : random_star(random, radius);
    drawing.shapes.push_back({{moved(std::move(contour), centre)}, greys[i % 5]});
  }
  return drawing;
}

Drawing cross(double size, double bar, double grey) {
  const double a = size / 2.0;
  const double b = bar / 2.0;
  return {
      {{{{{-b, -a}, {b, -a}, {b, -b}, {a, -b}, {a, b}, {b, b}, {b, a}, {-b, a}, {-b, b}, {-a, b}, {-a, -b}, {-b, -b}}},
        grey}},
      size,
      size};
}

Drawing wafer_mark(double size) {
  Drawing drawing{{}, size, size};
  const double h = size / 2.0;
  const double f = 0.42 * size;
  Contour hole = rectangle(-f + 0.08 * size, -f + 0.08 * size, f - 0.08 * size, f - 0.08 * size);
  std::reverse(hole.begin(), hole.end());
  drawing.shapes.push_back({{rectangle(-f, -f, f, f), hole}, 110.0});
  for (const double angle : {0.0, 90.0, 180.0, 270.0}) {
    drawing.shapes.push_back({{turned(rectangle(0.07 * size, -0.05 * size, 0.27 * size, 0.05 * size), angle)}, 60.0});
  }
  drawing.shapes.push_back({{rectangle(0.14 * size, -0.28 * size, 0.26 * size, -0.16 * size)}, 60.0});
  drawing.shapes.push_back({{rectangle(-0.27 * size, 0.17 * size, -0.13 * size, 0.25 * size)}, 235.0});
  drawing.width = drawing.height = 2.0 * h;
  return drawing;
}

Scene target_sheet(double light, double dark) {
  Scene scene;
  scene.background = light;
  for (const double x : {50.0, 589.0}) {
    for (const double y : {50.0, 429.0}) {
      Item square;
      square.drawing = {{{{rectangle(-25.0, -25.0, 25.0, 25.0)}, dark}}, 50.0, 50.0};
      square.pose.x = x;
      square.pose.y = y;
      scene.items.push_back(square);
    }
  }
  return scene;
}

}  // namespace vsfind::render
