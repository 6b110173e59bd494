#pragma once
/// @file
/// The recorded sequence that ships with the tests and the quickstart: a part on a conveyor that moves and turns, seen
/// by an interlaced camera whose fields are exposed one after the other, in clutter; one frame has no part.

#include <optional>
#include <string>

#include "app/render/sensor.h"
#include "finder/pose.h"

namespace vsfind::render {

inline constexpr int sequence_frames = 26;
inline constexpr int sequence_empty_frame = 13;
inline constexpr Roi sequence_roi{245, 175, 151, 131};  ///< of the pattern in the training picture

/// The part at rest, in a full progressive frame.
[[nodiscard]] Picture sequence_training();

/// Frame 0 … sequence_frames − 1, top field first.
[[nodiscard]] Picture sequence_frame(int frame);

/// What a finder trained on the ROI of the training picture must answer for a field (Field::top or bottom), in frame
/// coordinates; nothing in the empty frame.
[[nodiscard]] std::optional<Pose> sequence_truth(int frame, Field field);

/// Writes conveyor.y4m, training.png and truth.csv into the folder. Throws IoError.
void write_sequence(const std::string& folder);

}  // namespace vsfind::render
