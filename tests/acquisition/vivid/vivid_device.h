#pragma once
/// @file
/// What the guest does to vivid itself, past the program under test: faults by its controls, and frames shown through
/// its output.

#include <cstdint>
#include <string>

#include "tests/acquisition/vivid/shown_frame.h"

namespace vsfind::test {

/// Sets a control of vivid by the name in its documentation. Throws std::runtime_error.
void set_vivid(const std::string& device, const std::string& control, std::int64_t value);

/// Selects a capture device's input and, where `lines_525` or not matters, its standard.
void select_vivid(const std::string& device, std::uint32_t input, bool analogue, bool lines_525);

/// Makes a capture device write its picture into a quarter of its buffers, as another program may have left it.
void shrink_picture(const std::string& device);

enum class Signal : std::uint8_t { pal, ntsc, hdmi };

/// Takes the 640x480 timings, for HDMI inputs and outputs.
void set_vivid_timings(const std::string& device);

/// Shows frames through an output, 0, 1, 2, … without end, in a field order of V4L2, as GREY or YUYV. `ready` is called
/// once the first frames were shown. Does not return.
[[noreturn]] void show(const std::string& device, Signal signal, const ShownFrames& frames, std::uint32_t field,
                       bool yuyv, void (*ready)());

}  // namespace vsfind::test
