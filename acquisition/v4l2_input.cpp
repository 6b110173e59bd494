#include "acquisition/v4l2_input.h"

#include <fmt/format.h>
#include <strings.h>

#include <cerrno>
#include <charconv>
#include <vector>

namespace vsfind {
namespace {

bool same_word(const std::string& a, const std::string& b) { return ::strcasecmp(a.c_str(), b.c_str()) == 0; }
bool begins_with(const std::string& text, const std::string& begin) {
  return text.size() > begin.size() && same_word(text.substr(0, begin.size()), begin);
}

std::vector<v4l2_input> inputs_of(const V4l2Device& device) {
  std::vector<v4l2_input> inputs;
  v4l2_input input{};
  while (device.call(VIDIOC_ENUMINPUT, &input) == 0) {
    inputs.push_back(input);
    const std::uint32_t index = input.index + 1;
    input = {};
    input.index = index;
  }
  return inputs;
}

/// By number, by name, or by the begin of one name only.
const v4l2_input& find_input(const V4l2Device& device, const std::vector<v4l2_input>& inputs,
                             const std::string& wanted) {
  const v4l2_input* beginning = nullptr;
  int beginnings = 0;
  for (const v4l2_input& input : inputs) {
    const std::string name = fixed_text(input.name);
    if (same_word(name, wanted) || std::to_string(input.index) == wanted) return input;
    if (begins_with(name, wanted)) {
      beginning = &input;
      ++beginnings;
    }
  }
  if (beginnings == 1) return *beginning;
  std::string allowed;
  for (const v4l2_input& input : inputs)
    allowed += fmt::format("{}{} or '{}'", allowed.empty() ? "" : ", ", input.index, fixed_text(input.name));
  throw UsageError(fmt::format("{}: has no input '{}' (allowed: {})", device.name(), wanted, allowed));
}

std::vector<v4l2_standard> standards_of(const V4l2Device& device) {
  std::vector<v4l2_standard> standards;
  v4l2_standard standard{};
  while (device.call(VIDIOC_ENUMSTD, &standard) == 0) {
    standards.push_back(standard);
    const std::uint32_t index = standard.index + 1;
    standard = {};
    standard.index = index;
  }
  return standards;
}

constexpr v4l2_std_id std_525 = V4L2_STD_525_60;
constexpr v4l2_std_id std_625 = V4L2_STD_625_50;

/// What the device says of the signal; 0 where that is not one kind only.
v4l2_std_id detected_standard(const V4l2Device& device) {
  v4l2_std_id detected = 0;
  if (device.call(VIDIOC_QUERYSTD, &detected) != 0) return 0;
  return ((detected & std_525) != 0) == ((detected & std_625) != 0) ? 0 : detected;
}

/// The standard that is asked for by name; 0 for "auto".
v4l2_std_id wanted_standard(const V4l2Device& device, const V4l2Input& input,
                            const std::vector<v4l2_standard>& standards, const std::string& wanted) {
  if (same_word(wanted, "auto")) return 0;
  if (standards.empty())
    throw UsageError(fmt::format("{}: input '{}' has no video standards, '{}' cannot be chosen (allowed: none)",
                                 device.name(), input.name, wanted));
  std::string allowed = "auto";
  v4l2_std_id possible = 0;
  for (const v4l2_standard& standard : standards) {
    const std::string name = fixed_text(standard.name);
    if (same_word(name, wanted)) return standard.id;
    allowed += ", " + name;
    possible |= standard.id;
  }
  // The families, for drivers that name only their members.
  constexpr v4l2_std_id pal = V4L2_STD_PAL;
  constexpr v4l2_std_id ntsc = V4L2_STD_NTSC;
  constexpr v4l2_std_id secam = V4L2_STD_SECAM;
  const v4l2_std_id family = same_word(wanted, "PAL")     ? pal
                             : same_word(wanted, "NTSC")  ? ntsc
                             : same_word(wanted, "SECAM") ? secam
                                                          : 0;
  if ((family & possible) != 0) return family & possible;
  throw UsageError(
      fmt::format("{}: input '{}' has no standard '{}' (allowed: {})", device.name(), input.name, wanted, allowed));
}

void select_standard(const V4l2Device& device, const CameraSettings& settings, V4l2Input& input) {
  const std::vector<v4l2_standard> standards = standards_of(device);
  v4l2_std_id set = 0;
  if (!settings.standard.empty()) set = wanted_standard(device, input, standards, settings.standard);
  if (standards.empty()) return;
  v4l2_std_id current = 0;
  device.require(VIDIOC_G_STD, &current, "does not tell its standard");
  v4l2_std_id detected = detected_standard(device);
  if (set == 0 && (detected & current) == 0) set = detected;  // follows the signal
  if (set != 0 && (set & current) != current) {
    device.require(VIDIOC_S_STD, &set, "takes no other standard");
    device.require(VIDIOC_G_STD, &current, "does not tell its standard");
    detected = detected_standard(device);
  }
  if (detected != 0 && ((detected & std_525) != 0) != ((current & std_525) != 0))
    throw CameraError(fmt::format("{}: the signal has {} lines, the standard '{}' others", device.name(),
                                  (detected & std_525) != 0 ? 525 : 625, settings.standard));
  input.standard = current;
  input.lines_525 = (current & std_525) != 0;
  input.standard_lines = input.lines_525 ? 480 : 576;
  for (const v4l2_standard& standard : standards) {
    // The closest name: one for all of the current ones goes before one for some of them.
    const bool whole = (standard.id & current) == current;
    if ((standard.id & current) == 0 || (!input.standard_name.empty() && !whole)) continue;
    input.standard_name = fixed_text(standard.name);
    input.frame_rate = {standard.frameperiod.denominator, standard.frameperiod.numerator};
    if (whole) break;
  }
}

void select_timings(const V4l2Device& device, V4l2Input& input) {
  v4l2_dv_timings timings{};
  switch (const int error = device.call(VIDIOC_QUERY_DV_TIMINGS, &timings)) {
    case 0: {
      v4l2_dv_timings current{};
      const bool same = device.call(VIDIOC_G_DV_TIMINGS, &current) == 0 && current.bt.width == timings.bt.width &&
                        current.bt.height == timings.bt.height && current.bt.interlaced == timings.bt.interlaced &&
                        current.bt.pixelclock == timings.bt.pixelclock;
      if (!same) device.require(VIDIOC_S_DV_TIMINGS, &timings, "does not take the timings of its signal");
      break;
    }
    case ENOLINK:
      throw CameraError(fmt::format("{}: no signal at input '{}'", device.name(), input.name));
    case ENOLCK:
      throw CameraError(fmt::format("{}: the signal at input '{}' is unstable", device.name(), input.name));
    case ERANGE:
      throw CameraError(fmt::format("{}: the signal at input '{}' is out of range", device.name(), input.name));
    case ENODEV:
      throw device.failure("does not tell its timings", error);
    default:  // cannot detect: as it is set
      break;
  }
  if (device.call(VIDIOC_G_DV_TIMINGS, &timings) != 0) return;
  input.timings = timings.bt;
  const v4l2_bt_timings& bt = timings.bt;
  const std::int64_t line = std::int64_t{bt.width} + bt.hfrontporch + bt.hsync + bt.hbackporch;
  const std::int64_t lines =
      std::int64_t{bt.height} + bt.vfrontporch + bt.vsync + bt.vbackporch +
      (bt.interlaced != 0 ? std::int64_t{bt.il_vfrontporch} + bt.il_vsync + bt.il_vbackporch : 0);
  input.frame_rate = {static_cast<std::int64_t>(bt.pixelclock), line * lines};
}

}  // namespace

std::string signal_problem(const V4l2Device& device) {
  std::uint32_t index = 0;
  if (device.call(VIDIOC_G_INPUT, &index) != 0) return {};
  v4l2_input input{};
  input.index = index;
  if (device.call(VIDIOC_ENUMINPUT, &input) != 0) return {};
  const std::string where = fmt::format("at input '{}'", fixed_text(input.name));
  constexpr std::uint32_t unlocked =
      V4L2_IN_ST_NO_H_LOCK | V4L2_IN_ST_NO_V_LOCK | V4L2_IN_ST_NO_SYNC | V4L2_IN_ST_NO_CARRIER;
  if ((input.status & V4L2_IN_ST_NO_POWER) != 0) return "no power " + where;
  if ((input.status & V4L2_IN_ST_NO_SIGNAL) != 0) return "no signal " + where;
  if ((input.status & unlocked) != 0) return "an unstable signal " + where;
  return {};
}

V4l2Input select_input(const V4l2Device& device, const CameraSettings& settings) {
  V4l2Input result{};
  const std::vector<v4l2_input> inputs = inputs_of(device);
  int index = 0;
  if (device.call(VIDIOC_G_INPUT, &index) != 0 || inputs.empty()) {
    if (!settings.input.empty())
      throw UsageError(fmt::format("{}: has no inputs, '{}' cannot be chosen", device.name(), settings.input));
    return result;
  }
  if (!settings.input.empty()) {
    const int wanted = static_cast<int>(find_input(device, inputs, settings.input).index);
    if (wanted != index) {
      index = wanted;
      device.require(VIDIOC_S_INPUT, &index, "takes no other input");
    }
  }
  std::uint32_t capabilities = 0;
  for (const v4l2_input& input : inputs) {
    if (input.index != static_cast<std::uint32_t>(index)) continue;
    result.index = input.index;
    result.name = fixed_text(input.name);
    capabilities = input.capabilities;
  }
  if (const std::string problem = signal_problem(device); !problem.empty())
    throw CameraError(fmt::format("{}: {}", device.name(), problem));
  select_standard(device, settings, result);
  if ((capabilities & V4L2_IN_CAP_DV_TIMINGS) != 0) select_timings(device, result);
  return result;
}

}  // namespace vsfind
