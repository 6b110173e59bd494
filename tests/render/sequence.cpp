#include "sequence.h"

#include <fmt/core.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "acquisition/errors.h"
#include "app/render/clutter.h"
#include "app/render/patterns.h"
#include "app/render/random.h"
#include "app/render/truth.h"

namespace vsfind::render {
namespace {

constexpr double blur = 0.7;
constexpr double noise = 2.0;
constexpr Pose training_pose{320.3, 239.6, 0.0, 1.0, 1.0};

Drawing part() { return artwork(3, 150.0, 130.0); }

/// The part's pose at the exposure of a field, counted from 0: 4 to 5.5 pixels and 0.3 to 0.5 degrees from one to the
/// next.
Pose pose_at(int field) {
  const double t = field;
  Pose pose;
  pose.x = 170.37 + 4.2 * t;
  pose.y = 250.81 - 45.0 * std::sin(2.0 * std::numbers::pi * t / 80.0);
  pose.angle_deg = -10.2 + 0.4 * t + 1.2 * std::sin(2.0 * std::numbers::pi * t / 90.0);
  return pose;
}

Scene conveyor() {
  Scene scene;
  scene.background = 185.0;
  Random random(20260);
  Clutter clutter;
  clutter.count = 45;
  clutter.decoys = 0.15;
  clutter.greys = {185.0, 90.0, 30.0, 220.0, 150.0};
  add_clutter(scene, random, clutter);
  return scene;
}

Sensor sensor_of(std::uint64_t seed) {
  Sensor sensor;
  sensor.noise = noise;
  sensor.shade_x = 0.06;
  sensor.shade_y = -0.04;
  sensor.seed = seed;
  return sensor;
}

Exposure field_exposure(int frame, Field field) {
  Scene scene = conveyor();
  if (frame != sequence_empty_frame) {
    scene.items.push_back({part(), pose_at(2 * frame + first_line(field))});
  }
  return expose(scene, blur, field);
}

void write_bytes(std::ofstream& file, const Picture& picture) {
  file.write(reinterpret_cast<const char*>(picture.bytes().data()),
             static_cast<std::streamsize>(picture.bytes().size()));
}

}  // namespace

Picture sequence_training() {
  Scene scene;
  scene.background = 185.0;
  scene.items.push_back({part(), training_pose});
  return develop(expose(scene, blur), sensor_of(4711));
}

Picture sequence_frame(int frame) {
  const Exposure woven = weave(field_exposure(frame, Field::top), field_exposure(frame, Field::bottom));
  return develop(woven, sensor_of(5000 + static_cast<std::uint64_t>(frame)));
}

std::optional<Pose> sequence_truth(int frame, Field field) {
  if (frame == sequence_empty_frame) return std::nullopt;
  return expected_pose(training_pose, pose_at(2 * frame + first_line(field)), roi_centre(sequence_roi));
}

void write_sequence(const std::string& folder) {
  const std::string recording = folder + "/conveyor.y4m";
  std::ofstream y4m(recording, std::ios::binary);
  std::ofstream truth(folder + "/truth.csv");
  y4m << "YUV4MPEG2 W640 H480 F25:1 It A1:1 Cmono\n";
  truth << "frame,field,x,y,angle_deg\n";
  for (int frame = 0; frame < sequence_frames; ++frame) {
    y4m << "FRAME\n";
    write_bytes(y4m, sequence_frame(frame));
    for (const Field field : {Field::top, Field::bottom}) {
      const std::optional<Pose> pose = sequence_truth(frame, field);
      truth << (pose
                    ? fmt::format("{},{},{:.5f},{:.5f},{:.5f}\n", frame, name(field), pose->x, pose->y, pose->angle_deg)
                    : fmt::format("{},{},,,\n", frame, name(field)));
    }
  }
  y4m.close();
  truth.close();
  if (!y4m || !truth) throw IoError(fmt::format("{}: the sequence cannot be written", folder));
  Picture training = sequence_training();
  const cv::Mat pixels(training.height(), training.width(), CV_8UC1, training.bytes().data());
  const std::string picture = folder + "/training.png";
  if (!cv::imwrite(picture, pixels, {cv::IMWRITE_PNG_COMPRESSION, 9})) {
    throw IoError(fmt::format("{}: cannot be written", picture));
  }
}

}  // namespace vsfind::render
