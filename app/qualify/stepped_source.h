#pragma once
/// @file
/// A camera in front of a stage: of its frames those that show the target standing still, one for each step.

#include <cstddef>
#include <functional>
#include <memory>

#include "acquisition/source.h"

namespace vsfind {

/// When a step's picture is taken.
struct StepChoice {
  enum class Kind {
    every,     ///< every frame is one: the stage triggers the camera
    line,      ///< once for every line that comes from `input`: somebody presses Enter
    interval,  ///< once every `interval_s` seconds
  };
  Kind kind = Kind::every;
  double interval_s = 0.0;
  int input = 0;                                    ///< file descriptor; its end is the end of the steps
  std::function<void(std::size_t step)> on_wait{};  ///< called before a step's line is waited for; steps from 0
};

/// Hands on one good frame for each step, numbered from 0: the second one that comes after the step began, as the first
/// may have been exposed before. Frames between are given back at once. With StepChoice::Kind::every it is the camera
/// itself.
[[nodiscard]] std::unique_ptr<FrameSource> open_stepped(std::unique_ptr<FrameSource> camera, StepChoice choice);

}  // namespace vsfind
