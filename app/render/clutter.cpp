#include "app/render/clutter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/render/patterns.h"
#include "app/render/truth.h"

namespace vsfind::render {
namespace {

constexpr double degrees = std::numbers::pi / 180.0;

double any_grey(Random& random, const Clutter& clutter) {
  const int last = static_cast<int>(clutter.greys.size()) - 1;
  const double grey = clutter.greys[static_cast<std::size_t>(random.integer(0, last))];
  return std::clamp(grey + random.uniform(-15.0, 15.0), 5.0, 250.0);
}

Drawing plain_shape(Random& random, const Clutter& clutter, double size) {
  const double half = size / 2.0;
  const double grey = any_grey(random, clutter);
  switch (random.integer(0, 4)) {
    case 0: {
      const double other = half * random.uniform(0.2, 1.0);
      return {{{{rectangle(-half, -other, half, other)}, grey}}, size, size};
    }
    case 1:
      return disc(size, grey);
    case 2:
      return ring(size, size * random.uniform(0.3, 0.8), grey);
    case 3:
      return {{{{random_blob(random, half)}, grey}}, size, size};
    default:
      return {{{{random_star(random, half)}, grey}}, size, size};
  }
}

/// Like a part of the patterns: a few nested squares, or a plate with blobs.
Drawing decoy(Random& random, const Clutter& clutter, double size) {
  if (random.chance(0.5)) {
    const double step = random.uniform(14.0, 28.0);
    Drawing nested = bullseye(size, step, any_grey(random, clutter), any_grey(random, clutter));
    nested.shapes.resize(std::min<std::size_t>(nested.shapes.size(), 2));
    return nested;
  }
  return artwork(random.bits() % 100000 + 1000, size, size * random.uniform(0.6, 1.0));
}

}  // namespace

Contour random_blob(Random& random, double radius) {
  double amplitude[4];
  double phase[4];
  for (int k = 0; k < 4; ++k) {
    amplitude[k] = random.uniform(-0.22, 0.22) / (1.0 + 0.4 * k);
    phase[k] = random.uniform(0.0, 360.0) * degrees;
  }
  Contour contour;
  constexpr int corners = 240;
  for (int i = 0; i < corners; ++i) {
    const double angle = 360.0 * degrees * i / corners;
    double r = 1.0;
    for (int k = 0; k < 4; ++k) r += amplitude[k] * std::cos((k + 2) * angle + phase[k]);
    contour.emplace_back(radius * r * std::cos(angle), radius * r * std::sin(angle));
  }
  return contour;
}

Contour random_star(Random& random, double radius) {
  Contour contour;
  const int corners = random.integer(3, 8);
  const double turn = random.uniform(0.0, 360.0);
  for (int i = 0; i < corners; ++i) {
    const double angle = (turn + 360.0 * (i + random.uniform(-0.3, 0.3)) / corners) * degrees;
    const double r = radius * random.uniform(0.55, 1.25);
    contour.emplace_back(r * std::cos(angle), r * std::sin(angle));
  }
  return contour;
}

void add_clutter(Scene& scene, Random& random, const Clutter& clutter) {
  for (int i = 0; i < clutter.count; ++i) {
    const double size = clutter.smallest * std::pow(clutter.largest / clutter.smallest, random.uniform());
    const bool similar = random.chance(clutter.decoys);
    Item item;
    item.drawing = similar ? decoy(random, clutter, std::max(size, 40.0)) : plain_shape(random, clutter, size);
    item.pose.x = random.uniform(-20.0, scene.width + 20.0);
    item.pose.y = random.uniform(-20.0, scene.height + 20.0);
    item.pose.angle_deg = random.uniform(-180.0, 180.0);
    scene.items.push_back(std::move(item));
  }
}

Drawing occluders(Random& random, const Drawing& drawing, double part) {
  const double w = drawing.width;
  const double h = drawing.height;
  // The unit things; their common size is then found by bisection.
  struct Thing {
    Contour contour;
    Eigen::Vector2d centre;
    double grey;
    std::uint64_t texture;
  };
  std::vector<Thing> things;
  const int kind = random.integer(0, 2);
  const int count = kind == 0 ? 1 : kind == 1 ? 1 : 3;
  for (int i = 0; i < count; ++i) {
    Thing thing;
    if (kind == 0) {  // something large that comes in from a side
      const double side = random.uniform(0.0, 360.0) * degrees;
      thing.contour = turned(rectangle(-0.5, -1.2, 0.5, 1.2), side / degrees);
      for (Eigen::Vector2d& p : thing.contour) p = Eigen::Vector2d(p.x() * w, p.y() * h);
      thing.centre = Eigen::Vector2d(0.62 * w * std::cos(side), 0.62 * h * std::sin(side));
    } else {
      thing.contour = random.chance(0.5) ? random_blob(random, 0.5) : random_star(random, 0.5);
      for (Eigen::Vector2d& p : thing.contour) p = Eigen::Vector2d(p.x() * w, p.y() * h);
      thing.centre = Eigen::Vector2d(random.uniform(-0.4, 0.4) * w, random.uniform(-0.4, 0.4) * h);
    }
    thing.grey = random.uniform(20.0, 235.0);
    thing.texture = random.bits();
    things.push_back(std::move(thing));
  }
  const auto outlines = [&](double size) {
    Drawing cover{{}, w, h};
    for (const Thing& thing : things) {
      Contour contour = thing.contour;
      for (Eigen::Vector2d& p : contour) p *= size;
      cover.shapes.push_back({{moved(std::move(contour), thing.centre)}, thing.grey});
    }
    return cover;
  };
  double low = 0.0;
  double high = 4.0;
  for (int i = 0; i < 24; ++i) {
    const double middle = (low + high) / 2.0;
    (hidden_part(drawing, outlines(middle)) < part ? low : high) = middle;
  }
  Drawing cover = outlines(low);
  for (const Thing& thing : things) {  // texture: small blobs, kept within by their smallness
    Random texture(thing.texture);
    for (int i = 0; i < 6; ++i) {
      const Eigen::Vector2d& corner =
          thing.contour[static_cast<std::size_t>(texture.integer(0, static_cast<int>(thing.contour.size()) - 1))];
      const Eigen::Vector2d centre = thing.centre + corner * (low * texture.uniform(0.0, 0.7));
      Contour blob = random_blob(texture, 0.1 * low * std::min(w, h) * texture.uniform(0.4, 0.9));
      cover.shapes.push_back({{moved(std::move(blob), centre)}, texture.uniform(10.0, 245.0)});
    }
  }
  return cover;
}

Drawing remapped(Random& random, const Drawing& drawing, double background, int features) {
  Drawing result = drawing;
  std::vector<double> below{background};
  for (std::size_t i = 0; i < result.shapes.size(); ++i) {
    double grey = 0.0;
    bool distinct = false;
    for (int attempt = 0; attempt < 1000 && !distinct; ++attempt) {
      grey = random.uniform(10.0, 245.0);
      distinct = std::all_of(below.begin(), below.end(), [&](double b) { return std::abs(b - grey) >= 35.0; });
    }
    result.shapes[i].grey = grey;
    below = {result.shapes.front().grey, grey};
  }
  const double unit = std::min(drawing.width, drawing.height);
  for (int i = 0; i < features; ++i) {
    const double radius = unit * random.uniform(0.03, 0.07);
    const Eigen::Vector2d centre(random.uniform(-0.38, 0.38) * drawing.width,
                                 random.uniform(-0.38, 0.38) * drawing.height);
    Contour contour = random.chance(0.5) ? random_blob(random, radius) : random_star(random, radius);
    result.shapes.push_back({{moved(std::move(contour), centre)}, random.uniform(10.0, 245.0)});
  }
  return result;
}

std::optional<Pose> random_place(Random& random, const Scene& scene, const Item& item, double outside) {
  Item trial = item;
  for (int attempt = 0; attempt < 500; ++attempt) {
    trial.pose.x = random.uniform(0.0, scene.width - 1.0);
    trial.pose.y = random.uniform(0.0, scene.height - 1.0);
    if (outside <= 0.0) {
      bool within = true;
      for (const auto& [u, v] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
        const Eigen::Vector2d p = frame_from_drawing(
            scene, trial, Eigen::Vector2d(u * item.drawing.width / 2.0, v * item.drawing.height / 2.0));
        within = within && p.x() > 2.0 && p.y() > 2.0 && p.x() < scene.width - 3.0 && p.y() < scene.height - 3.0;
      }
      if (within) return trial.pose;
      continue;
    }
    // Move outwards from a place inside until enough is outside.
    const double direction = random.uniform(0.0, 360.0) * degrees;
    const Eigen::Vector2d start(trial.pose.x, trial.pose.y);
    if (outside_part(scene, trial) > outside) continue;
    double low = 0.0;
    double high = 900.0;
    for (int i = 0; i < 20; ++i) {
      const double middle = (low + high) / 2.0;
      trial.pose.x = start.x() + middle * std::cos(direction);
      trial.pose.y = start.y() + middle * std::sin(direction);
      (outside_part(scene, trial) < outside ? low : high) = middle;
    }
    return trial.pose;
  }
  return std::nullopt;
}

}  // namespace vsfind::render
