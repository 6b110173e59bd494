#include "stage.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "dump.h"

namespace vsfind::measure {

using render::Random;

std::string dump_folder;

const char* name(Kind kind) {
  return kind == Kind::bullseye ? "bullseye" : kind == Kind::artwork ? "artwork" : "small artwork";
}

render::Drawing drawing_of(Kind kind) {
  switch (kind) {
    case Kind::bullseye:
      return render::bullseye();
    case Kind::artwork:
      return render::artwork(3, 150.0, 130.0);
    default:
      return render::artwork(5, 100.0, 86.0);
  }
}

namespace {

render::Drawing enlarged(render::Drawing drawing, double by) {
  if (by == 1.0) return drawing;
  for (render::Shape& shape : drawing.shapes) {
    for (render::Contour& contour : shape.contours) {
      for (Eigen::Vector2d& p : contour) p *= by;
    }
  }
  drawing.width *= by;
  drawing.height *= by;
  return drawing;
}

render::Scene sheet(double size) {
  render::Scene scene = render::target_sheet();
  if (size == 1.0) return scene;
  scene.width = static_cast<int>(std::lround(scene.width * size));
  scene.height = static_cast<int>(std::lround(scene.height * size));
  for (render::Item& item : scene.items) {
    item.drawing = enlarged(item.drawing, size);
    item.pose.x *= size;
    item.pose.y *= size;
  }
  return scene;
}

Shot finish(const render::Scene& scene, double blur, const render::Sensor& sensor, Field field) {
  Shot shot;
  shot.picture = render::develop(render::expose(scene, blur, field), sensor);
  shot.mapping = Mapping().for_field(field);
  return shot;
}

void add_pattern(render::Scene& scene, Random& random, const Trained& trained, const Recipe& recipe, const Pose& pose) {
  const render::Drawing& drawing = trained.drawing;
  if (recipe.quiet_zone) {
    const double w = drawing.width / 2.0 + 12.0;
    const double h = drawing.height / 2.0 + 12.0;
    scene.items.push_back({{{{{render::rectangle(-w, -h, w, h)}, scene.background}}, 2 * w, 2 * h}, pose});
  }
  scene.items.push_back(
      {recipe.remap ? render::remapped(random, drawing, scene.background, random.integer(2, 4)) : drawing, pose});
  if (recipe.hidden > 0.0) scene.items.push_back({render::occluders(random, drawing, recipe.hidden), pose});
}

bool far_enough(const std::vector<Pose>& others, const Pose& pose, const render::Drawing& drawing) {
  const double reach = std::hypot(drawing.width, drawing.height);
  return std::all_of(others.begin(), others.end(),
                     [&](const Pose& other) { return std::hypot(other.x - pose.x, other.y - pose.y) > reach; });
}

}  // namespace

Trained train_on(const Training& training) {
  Trained trained;
  trained.training = training;
  trained.drawing = enlarged(drawing_of(training.kind), training.size);
  Random random(training.seed * 1000003 + 7);
  render::Scene scene = sheet(training.size);
  TrainOptions options;
  options.name = name(training.kind);
  options.roi.width = static_cast<int>(std::lround(trained.drawing.width));
  options.roi.height = static_cast<int>(std::lround(trained.drawing.height));
  options.roi.x = (scene.width - options.roi.width) / 2;
  options.roi.y = (scene.height - options.roi.height) / 2;
  trained.origin = render::roi_centre(options.roi);
  trained.pose.x = trained.origin.x() + random.uniform(-0.5, 0.5);
  trained.pose.y = trained.origin.y() + random.uniform(-0.5, 0.5);
  scene.items.push_back({trained.drawing, trained.pose});
  render::Sensor sensor;
  sensor.noise = training.noise;
  sensor.seed = random.bits();
  const Shot shot = finish(scene, 0.7, sensor, Field::frame);
  options.angle_deg = training.angle;
  options.scale_x = training.scale;
  options.scale_y = training.scale;
  options.accuracy = training.accuracy;
  options.edges = training.edges;
  options.polarity = training.polarity;
  trained.pattern = std::make_shared<const Pattern>(train(shot.picture.view(), shot.mapping, options));
  return trained;
}

Shot random_shot(const Trained& trained, const Recipe& recipe, std::uint64_t seed) {
  Random random(seed * 2654435761ULL + 99);
  render::Scene scene;
  scene.background = random.uniform(recipe.background.min, recipe.background.max);
  std::vector<Pose> places;
  for (int whole_scene = 0; whole_scene < 200 && static_cast<int>(places.size()) < recipe.instances; ++whole_scene) {
    places.clear();
    for (int attempt = 0; attempt < 300 && static_cast<int>(places.size()) < recipe.instances; ++attempt) {
      render::Item item{trained.drawing, {}};
      item.pose.angle_deg = random.uniform(-recipe.angle_limit, recipe.angle_limit);
      item.pose.scale_x = random.uniform(recipe.scale.min, recipe.scale.max);
      item.pose.scale_y = random.uniform(recipe.scale.min, recipe.scale.max);
      const auto place = render::random_place(random, scene, item, recipe.outside);
      if (place && far_enough(places, *place, trained.drawing)) places.push_back(*place);
    }
  }
  render::Clutter clutter;
  clutter.count = recipe.clutter;
  clutter.decoys = recipe.decoys;
  clutter.greys = {scene.background};
  for (const render::Shape& shape : trained.drawing.shapes) clutter.greys.push_back(shape.grey);
  render::add_clutter(scene, random, clutter);
  for (const Pose& place : places) add_pattern(scene, random, trained, recipe, place);
  render::Sensor sensor = recipe.sensor;
  sensor.seed = random.bits();
  if (recipe.random_shading) {
    const double direction = random.uniform(0.0, 6.283);
    sensor.gain *= 0.5;
    sensor.shade_x = 0.55 * std::cos(direction);
    sensor.shade_y = 0.55 * std::sin(direction);
    sensor.ramp_x = 15.0 * std::cos(direction + 1.0);
    sensor.ramp_y = 15.0 * std::sin(direction + 1.0);
    sensor.offset += 30.0;
  }
  Shot shot = finish(scene, recipe.blur, sensor, recipe.field);
  for (const Pose& place : places) {
    shot.truth.push_back(render::expected_pose(trained.pose, place, trained.origin));
  }
  return shot;
}

Shot sheet_shot(const Trained& trained, const Pose& scene_pose, double blur, const render::Sensor& sensor,
                Field field) {
  render::Scene scene = sheet(trained.training.size);
  scene.items.push_back({trained.drawing, scene_pose});
  Shot shot = finish(scene, blur, sensor, field);
  shot.truth.push_back(render::expected_pose(trained.pose, scene_pose, trained.origin));
  return shot;
}

const std::vector<Match>& judge(Finder& finder, const Trained& trained, const Shot& shot, Row& row,
                                std::uint64_t seed) {
  const PatternMatches& answer = finder.find(shot.picture.view(), shot.mapping).front();
  row.ms.push_back(finder.search_ms());
  ++row.scenes;
  row.expected += static_cast<int>(shot.truth.size());
  std::vector<bool> taken(answer.matches.size(), false);
  bool failed = false;
  for (const Pose& truth : shot.truth) {
    // The nearest match that no other instance has claimed.
    std::size_t best = answer.matches.size();
    double nearest = 1e9;
    for (std::size_t i = 0; i < answer.matches.size(); ++i) {
      const double distance = std::hypot(answer.matches[i].pose.x - truth.x, answer.matches[i].pose.y - truth.y);
      if (!taken[i] && distance < nearest) {
        nearest = distance;
        best = i;
      }
    }
    if (best == answer.matches.size()) {
      failed = true;
      continue;
    }
    ++row.found;
    const Match& match = answer.matches[best];
    const Pose& pose = match.pose;
    const double turn = render::angle_difference_deg(pose.angle_deg, truth.angle_deg);
    if (nearest > 0.5 || std::abs(turn) > 0.3) {
      failed = true;
      continue;
    }
    taken[best] = true;
    ++row.right;
    row.x.add(pose.x - truth.x);
    row.y.add(pose.y - truth.y);
    row.angle.add(turn);
    row.scale_x.add(pose.scale_x - truth.scale_x);
    row.scale_y.add(pose.scale_y - truth.scale_y);
    row.ratio_x.add((pose.x - truth.x) / match.sigma_x);
    row.ratio_y.add((pose.y - truth.y) / match.sigma_y);
    row.ratio_angle.add(turn / match.sigma_angle_deg);
  }
  if (answer.matches.size() > shot.truth.size()) failed = true;
  if (failed && !dump_folder.empty()) {
    dump(dump_folder, fmt::format("{}-{}", row.name, seed), shot, *trained.pattern, answer.matches);
  }
  return answer.matches;
}

Finder finder_for(const Trained& trained, const SearchOptions& options) { return Finder({trained.pattern}, options); }

}  // namespace vsfind::measure
