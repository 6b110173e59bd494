#include "app/qualify/simulation.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>

#include "acquisition/recording.h"
#include "app/drawing.h"
#include "app/output_file.h"
#include "app/render/patterns.h"
#include "app/render/truth.h"
#include "app/report/page.h"
#include "app/result_output.h"

namespace vsfind {
namespace {

using PictureList = std::shared_ptr<const std::vector<render::Picture>>;

/// Keeps the pictures alive as long as a frame of them is out.
class PictureOwner final : public BufferOwner {
 public:
  explicit PictureOwner(PictureList pictures) : pictures_(std::move(pictures)) {}
  void give_back(std::uint32_t /*index*/) noexcept override {}

 private:
  PictureList pictures_;
};

class StageSource final : public FrameSource {
 public:
  explicit StageSource(const SimulatedStage& stage)
      : pictures_(stage.pictures), owner_(std::make_shared<PictureOwner>(stage.pictures)) {
    info_.name = std::string("simulated ") + name(stage.kind) + " stage";
    info_.width = simulation_width;
    info_.height = simulation_height;
    info_.pixel_aspect = {1, 1};
    info_.frames = pictures_->size();
  }
  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  std::optional<Frame> next() override {
    if (next_ >= pictures_->size()) return std::nullopt;
    FrameInfo info;
    info.sequence = next_;
    info.arrival_ns = monotonic_ns();
    const ImageView view = (*pictures_)[next_].view();
    return Frame(owner_, static_cast<std::uint32_t>(next_++), view, info);
  }
  void stop() noexcept override { next_ = pictures_->size(); }

 private:
  PictureList pictures_;
  std::shared_ptr<PictureOwner> owner_;
  SourceInfo info_;
  std::size_t next_ = 0;
};

/// The sheet with the bull's-eye in its middle, drawn around (0,0).
render::Scene sheet_at(const Pose& pose) {
  render::Scene scene = render::target_sheet();
  scene.items.push_back({render::bullseye(), {(scene.width - 1) / 2.0, (scene.height - 1) / 2.0, 0.0, 1.0, 1.0}});
  const Eigen::Vector2d middle((scene.width - 1) / 2.0, (scene.height - 1) / 2.0);
  for (auto& item : scene.items) {
    const Eigen::Vector2d place = plane_from_pattern(pose, Eigen::Vector2d(item.pose.x, item.pose.y) - middle);
    item.pose = {place.x(), place.y(), pose.angle_deg, 1.0, 1.0};
  }
  return scene;
}

Pose linear_pose(int step) {
  // Almost vertical: two degrees off.
  const double direction = 92.0 * std::numbers::pi / 180.0;
  const double way = simulation_step_px * step;
  return {319.87 + way * std::cos(direction), 236.41 + way * std::sin(direction), 0.0, 1.0, 1.0};
}

Pose rotary_pose(int step, int steps) {
  // The stage's axis is not quite in the middle of the bull's-eye.
  const Pose turned{321.3, 238.6, simulation_step_deg * (step - (steps - 1) / 2.0), 1.0, 1.0};
  const Eigen::Vector2d place = plane_from_pattern(turned, {-1.7, 1.1});
  return {place.x(), place.y(), turned.angle_deg, 1.0, 1.0};
}

}  // namespace

Simulation simulate_stages(const SimulationOptions& options) {
  Simulation simulation;
  render::Sensor sensor;
  sensor.noise = options.noise;
  const auto picture = [&](const Pose& pose, std::uint64_t number) {
    sensor.seed = options.seed * 1000003 + number;
    return render::develop(render::expose(sheet_at(pose), options.blur), sensor);
  };
  const Pose trained{319.73, 239.21, 0.0, 1.0, 1.0};
  simulation.training = picture(trained, 0);
  simulation.roi = {224, 144, 191, 191};
  const Eigen::Vector2d origin = render::roi_centre(simulation.roi);
  for (SimulatedStage* stage : {&simulation.linear, &simulation.rotary}) {
    stage->kind = stage == &simulation.linear ? StageKind::linear : StageKind::rotary;
    auto pictures = std::make_shared<std::vector<render::Picture>>();
    for (int i = 0; i < options.steps; ++i) {
      const bool linear = stage->kind == StageKind::linear;
      const Pose pose = linear ? linear_pose(i) : rotary_pose(i, options.steps);
      const std::uint64_t first = linear ? 1000 : 2000;
      pictures->push_back(picture(pose, first + static_cast<std::uint64_t>(i)));
      stage->truth.push_back(render::expected_pose(trained, pose, origin));
    }
    stage->pictures = std::move(pictures);
  }
  return simulation;
}

std::unique_ptr<FrameSource> open_stage(const SimulatedStage& stage) { return std::make_unique<StageSource>(stage); }

void write_simulation(const Simulation& simulation, const std::string& folder) {
  make_report_folder(folder);
  render::Picture training = simulation.training;
  write_png(folder + "/training.png", cv::Mat(training.height(), training.width(), CV_8UC1, training.bytes().data()));
  for (const SimulatedStage* stage : {&simulation.linear, &simulation.rotary}) {
    const std::string base = folder + "/" + name(stage->kind);
    const auto source = open_stage(*stage);
    SourceInfo info = source->info();
    info.frame_rate = {25, 1};
    RecordingWriter recording(base + ".y4m", info);
    OutputFile truth(base + ".csv");
    truth.write_line("frame,x,y,angle_deg");
    for (std::size_t i = 0; const auto frame = source->next(); ++i) {
      recording.append(*frame);
      const Pose& pose = stage->truth[i];
      truth.write_line(fmt::format("{},{:.6f},{:.6f},{:.6f}", i, pose.x, pose.y, pose.angle_deg));
    }
    recording.close();
  }
}

}  // namespace vsfind
