#include "calibrated_stage.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "app/render/clutter.h"
#include "app/render/patterns.h"
#include "app/render/truth.h"

namespace vsfind::measure {
namespace {

constexpr double focal_length = 1008.0;  // pixels: with the slant it gives a change of the scale by 40%
constexpr double distance = 500.0;       // mm
constexpr double radian = std::numbers::pi / 180.0;

PlanePose plane_at(double slant_deg) {
  PlanePose plane;
  plane.rotation = (Eigen::AngleAxisd(8.0 * radian, Eigen::Vector3d::UnitZ()) *
                    Eigen::AngleAxisd(slant_deg * radian, Eigen::Vector3d::UnitX()))
                       .toRotationMatrix();
  plane.translation = {12.0, -7.0, distance};
  return plane;
}

Camera lens_camera(const std::string& name, double slant_deg, const std::vector<double>& distortion,
                   double focal = focal_length) {
  const Lens lens(LensModel::polynomial, {focal, focal * 0.995, 322.4, 236.8}, distortion);
  return {name, Mapping::from_lens(lens, plane_at(slant_deg)), distance / focal, "mm"};
}

render::Scene scene_before(const Camera& camera) {
  render::Scene scene;
  scene.frame_from_plane = [mapping = camera.mapping](const Eigen::Vector2d& p) { return mapping.image_from_plane(p); };
  return scene;
}

/// Corners of the drawing's box, widened, in frame pixels.
std::vector<Eigen::Vector2d> box_in_frame(const render::Scene& scene, const render::Item& item, double wider) {
  const double w = item.drawing.width / 2.0 + wider;
  const double h = item.drawing.height / 2.0 + wider;
  std::vector<Eigen::Vector2d> corners;
  for (const auto& [u, v] : {std::pair{-w, -h}, {0.0, -h}, {w, -h}, {w, 0.0}, {w, h}, {0.0, h}, {-w, h}, {-w, 0.0}}) {
    corners.push_back(render::frame_from_drawing(scene, item, {u, v}));
  }
  return corners;
}

bool in_picture(const render::Scene& scene, const std::vector<Eigen::Vector2d>& points) {
  return std::all_of(points.begin(), points.end(), [&](const Eigen::Vector2d& p) {
    return p.x() > 4.0 && p.y() > 4.0 && p.x() < scene.width - 5.0 && p.y() < scene.height - 5.0;
  });
}

/// Clutter that lies on the plane all over the picture.
void add_clutter_on_plane(render::Scene& scene, const Camera& camera, render::Random& random, int count,
                          const render::Drawing& drawing) {
  render::Scene flat;
  render::Clutter clutter;
  clutter.count = count;
  clutter.largest = 60.0;
  clutter.decoys = 0.1;
  clutter.greys = {scene.background};
  for (const render::Shape& shape : drawing.shapes) clutter.greys.push_back(shape.grey);
  render::add_clutter(flat, random, clutter);
  for (render::Item& item : flat.items) {
    const Eigen::Vector2d at = camera.mapping.plane_from_image({item.pose.x, item.pose.y});
    if (!at.allFinite()) continue;
    item.pose.x = at.x();
    item.pose.y = at.y();
    item.pose.scale_x = item.pose.scale_y = camera.unit;
    // Where the lens model ends there is nothing to draw.
    bool seen = true;
    for (const render::Shape& shape : item.drawing.shapes) {
      for (const render::Contour& contour : shape.contours) {
        for (const Eigen::Vector2d& p : contour) {
          seen = seen && render::frame_from_drawing(scene, item, p).allFinite();
        }
      }
    }
    if (seen) scene.items.push_back(std::move(item));
  }
}

}  // namespace

Camera pixel_aspect_camera() { return {"aspect 59:54", Mapping::from_pixel_aspect(59.0 / 54.0), 1.0, "px"}; }
Camera slanted_camera() { return lens_camera("slant 35 deg", 35.0, {}); }
Camera slanted_lens_camera() {
  // At the corners the ray's length is 0.397: k1 and k2 shift them by 32 pixels.
  return lens_camera("slant 35 deg, lens 5%", 35.0, {-0.53, 0.20, 1e-3, -5e-4, 0.0});
}
Camera steep_camera() { return lens_camera("slant 50 deg, wide", 50.0, {}, 800.0); }
Camera straight_camera() { return lens_camera("straight", 0.0, {}); }

CalibratedPattern train_through(const Camera& camera, const render::Drawing& drawing, const Eigen::Vector2d& at,
                                const Range& angle, std::uint64_t seed, double noise) {
  CalibratedPattern trained;
  trained.drawing = drawing;
  render::Random random(seed * 1000003 + 7);
  render::Scene scene = scene_before(camera);
  const Eigen::Vector2d place =
      camera.mapping.plane_from_image(at + Eigen::Vector2d(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5)));
  trained.pose = {place.x(), place.y(), 0.0, camera.unit, camera.unit};
  scene.items.push_back({trained.drawing, trained.pose});
  Eigen::Vector2d low = at;
  Eigen::Vector2d high = at;
  for (const Eigen::Vector2d& corner : box_in_frame(scene, scene.items.back(), 0.0)) {
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
  }
  TrainOptions options;
  options.name = camera.name;
  options.unit = camera.plane_unit;
  options.roi.x = static_cast<int>(std::floor(low.x()));
  options.roi.y = static_cast<int>(std::floor(low.y()));
  options.roi.width = static_cast<int>(std::ceil(high.x())) - options.roi.x + 1;
  options.roi.height = static_cast<int>(std::ceil(high.y())) - options.roi.y + 1;
  options.angle_deg = angle;
  trained.origin = camera.mapping.plane_from_image(render::roi_centre(options.roi));
  render::Sensor sensor;
  sensor.seed = random.bits();
  sensor.noise = noise;
  const render::Picture picture = render::develop(render::expose(scene, 0.7), sensor);
  trained.pattern = std::make_shared<const Pattern>(train(picture.view(), camera.mapping, options));
  return trained;
}

CalibratedShot shot_through(const Camera& camera, const CalibratedPattern& pattern, const CalibratedRecipe& recipe,
                            std::uint64_t seed) {
  render::Random random(seed * 2654435761ULL + 99);
  render::Scene scene = scene_before(camera);
  add_clutter_on_plane(scene, camera, random, recipe.clutter, pattern.drawing);
  constexpr double quiet = 10.0;
  render::Item item{pattern.drawing, {}};
  item.pose.scale_x = item.pose.scale_y = camera.unit;
  for (bool placed = false; !placed;) {
    const Eigen::Vector2d at =
        camera.mapping.plane_from_image({random.uniform(0.0, scene.width), random.uniform(0.0, scene.height)});
    item.pose.x = at.x();
    item.pose.y = at.y();
    item.pose.angle_deg = random.uniform(-recipe.angle_limit, recipe.angle_limit);
    placed = at.allFinite() && in_picture(scene, box_in_frame(scene, item, 0.0));
  }
  const double w = pattern.drawing.width / 2.0 + quiet;
  const double h = pattern.drawing.height / 2.0 + quiet;
  scene.items.push_back({{{{{render::rectangle(-w, -h, w, h)}, scene.background}}, 2 * w, 2 * h}, item.pose});
  scene.items.push_back(item);
  render::Sensor sensor;
  sensor.noise = recipe.noise;
  sensor.seed = random.bits();
  CalibratedShot shot;
  shot.picture = render::develop(render::expose(scene, 0.7, recipe.field), sensor);
  shot.mapping = camera.mapping.for_field(recipe.field);
  shot.truth = render::expected_pose(pattern.pose, item.pose, pattern.origin);
  return shot;
}

CalibratedError error_of(const Match& match, const CalibratedShot& shot, const Pattern& pattern) {
  return {(match.pose.x - shot.truth.x) / pattern.pitch, (match.pose.y - shot.truth.y) / pattern.pitch,
          render::angle_difference_deg(match.pose.angle_deg, shot.truth.angle_deg)};
}

}  // namespace vsfind::measure
