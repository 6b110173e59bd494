#pragma once
/// @file
/// The paper's experiment rendered: a target sheet with a bull's-eye and four squares, moved by two stages under a
/// camera.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "acquisition/source.h"
#include "app/qualify/stage_analysis.h"
#include "app/render/sensor.h"
#include "finder/pose.h"

namespace vsfind {

struct SimulationOptions {
  double noise = 2.0;  ///< grey levels
  double blur = 0.7;   ///< sigma of the optics, pixels
  int steps = 20;      ///< pictures of each test
  std::uint64_t seed = 1;
};

inline constexpr int simulation_width = 640;
inline constexpr int simulation_height = 480;
inline constexpr double simulation_step_px = 1.0 / 3.0;  ///< of the linear stage
inline constexpr double simulation_step_deg = 0.42;      ///< of the rotary stage

/// Pictures of one stage, in memory, and the poses that a finder trained on the training picture must answer.
struct SimulatedStage {
  StageKind kind = StageKind::linear;
  std::shared_ptr<const std::vector<render::Picture>> pictures;
  std::vector<Pose> truth;
};

struct Simulation {
  render::Picture training;
  Roi roi;  ///< of the pattern, 191 × 191
  SimulatedStage linear;
  SimulatedStage rotary;
};

/// Renders everything; the same options give the same pictures everywhere.
[[nodiscard]] Simulation simulate_stages(const SimulationOptions& options);

/// The pictures as a source.
[[nodiscard]] std::unique_ptr<FrameSource> open_stage(const SimulatedStage& stage);

/// Writes training.png, and of each stage a recording and its truth: linear.y4m, linear.csv, rotary.y4m, rotary.csv.
/// Makes the folder where there is none. Throws IoError.
void write_simulation(const Simulation& simulation, const std::string& folder);

}  // namespace vsfind
