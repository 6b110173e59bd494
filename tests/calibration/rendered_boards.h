#pragma once
// Calibration boards seen by a known camera.

#include <vector>

#include "app/render/scene.h"
#include "app/render/sensor.h"
#include "calibration/board.h"
#include "calibration/mapping.h"

namespace vsfind::test {

/// The board as a drawing in its own coordinates (board.h). Circles are 0.5 pitch wide, markers 0.7 of a square.
[[nodiscard]] render::Drawing board_drawing(const BoardSpec& spec);

/// The board's middle.
[[nodiscard]] Eigen::Vector2d board_middle(const BoardSpec& spec);

/// Poses that tilt the board by `tilt_deg` to all sides, towards the image's corners in turn, the last in the middle.
[[nodiscard]] std::vector<PlanePose> board_poses(const BoardSpec& spec, int count, double tilt_deg, double distance);

/// A 640x480 frame or a field of it: blur 0.7 pixel, noise 2 grey levels.
[[nodiscard]] render::Picture board_picture(const BoardSpec& spec, const Mapping& mapping, Field lines = Field::frame,
                                            std::uint64_t seed = 1);

/// An interlaced frame whose two fields see the board through different mappings.
[[nodiscard]] render::Picture woven_picture(const BoardSpec& spec, const Mapping& top, const Mapping& bottom);

}  // namespace vsfind::test
