#pragma once
/// @file
/// What `qualify` is asked to do.

#include <string>
#include <vector>

#include "acquisition/camera.h"
#include "app/qualify/simulation.h"
#include "app/qualify/stepped_source.h"
#include "app/settings.h"

namespace vsfind {

struct QualifyRequest {
  std::string source;     ///< a sequence, or a camera's URI
  CameraSettings camera;  ///< of a camera
  StepChoice steps;       ///< of a camera
  std::vector<std::string> models;
  StageKind stage = StageKind::linear;
  FiducialChoice fiducials;
  SearchOptions search;
  MappingChoice mapping;
  Field field = Field::frame;
  std::size_t most_frames = 0;  ///< 0: all
  std::string report;           ///< folder, "" for none
  bool simulate = false;
  std::vector<int> accuracies{10, 20, 30};  ///< of the simulation
  SimulationOptions simulation;
  std::string images;                       ///< folder for the simulated pictures, "" for none
  std::vector<std::string> only_recorded;   ///< options given that --simulate has no use for
  std::vector<std::string> only_simulated;  ///< options given that need --simulate
  std::vector<std::string> only_live;       ///< options given that need a camera
};

/// The settings that fill `request`, which must outlive them.
[[nodiscard]] std::vector<Setting> qualify_settings(QualifyRequest& request);

/// Whether the source is a camera.
[[nodiscard]] bool is_camera(const std::string& source);

/// Checks what only all settings together can tell. Throws UsageError.
void complete_qualify_request(const QualifyRequest& request);

/// `10,20,30`: whole numbers of 1 to 100. Throws ValueError.
[[nodiscard]] std::vector<int> parse_accuracies(const std::string& text);

}  // namespace vsfind
