#include "acquisition/v4l2_controls.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

namespace vsfind {
namespace {

std::string plain(const std::string& text) {
  std::string letters;
  for (const char c : text) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0)
      letters += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return letters;
}

std::string name_of(const v4l2_query_ext_ctrl& control) { return fixed_text(control.name); }

bool usable(const v4l2_query_ext_ctrl& control) {
  const bool scalar = control.type >= V4L2_CTRL_TYPE_INTEGER && control.type <= V4L2_CTRL_TYPE_INTEGER_MENU &&
                      control.type != V4L2_CTRL_TYPE_CTRL_CLASS;
  return scalar && (control.flags & V4L2_CTRL_FLAG_DISABLED) == 0;
}

std::vector<v4l2_query_ext_ctrl> controls_of(const V4l2Device& device) {
  std::vector<v4l2_query_ext_ctrl> controls;
  v4l2_query_ext_ctrl control{};
  control.id = V4L2_CTRL_FLAG_NEXT_CTRL;
  while (device.call(VIDIOC_QUERY_EXT_CTRL, &control) == 0) {
    if (usable(control)) controls.push_back(control);
    const std::uint32_t id = control.id;
    control = {};
    control.id = id | V4L2_CTRL_FLAG_NEXT_CTRL;
  }
  return controls;
}

std::optional<std::int64_t> whole_number(std::string_view text) {
  const bool hex = text.starts_with("0x") || text.starts_with("0X");
  if (hex) text.remove_prefix(2);
  if (text.starts_with('+')) text.remove_prefix(1);
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, hex ? 16 : 10);
  if (error != std::errc{} || end != text.data() + text.size() || text.empty()) return std::nullopt;
  return value;
}

struct MenuEntry {
  std::int64_t index;
  std::string text;
};

std::vector<MenuEntry> menu_of(const V4l2Device& device, const v4l2_query_ext_ctrl& control) {
  std::vector<MenuEntry> entries;
  for (std::int64_t index = control.minimum; index <= control.maximum && entries.size() < 256; ++index) {
    v4l2_querymenu entry{};
    entry.id = control.id;
    entry.index = static_cast<std::uint32_t>(index);
    if (device.call(VIDIOC_QUERYMENU, &entry) != 0) continue;  // menus have holes
    entries.push_back(
        {index, control.type == V4L2_CTRL_TYPE_INTEGER_MENU ? std::to_string(entry.value) : fixed_text(entry.name)});
  }
  return entries;
}

/// What the control allows, for complaints.
std::string allowed_by(const V4l2Device& device, const v4l2_query_ext_ctrl& control) {
  switch (control.type) {
    case V4L2_CTRL_TYPE_BOOLEAN:
      return "on, off";
    case V4L2_CTRL_TYPE_MENU:
    case V4L2_CTRL_TYPE_INTEGER_MENU: {
      std::string text;
      for (const MenuEntry& entry : menu_of(device, control))
        text += fmt::format("{}{} or '{}'", text.empty() ? "" : ", ", entry.index, entry.text);
      return text;
    }
    case V4L2_CTRL_TYPE_STRING:
      return fmt::format("texts of {} to {} characters", control.minimum, control.maximum);
    case V4L2_CTRL_TYPE_BITMASK:
      return fmt::format("bits of {:#x}", static_cast<std::uint32_t>(control.maximum));
    default:
      return control.step > 1 ? fmt::format("{} to {} in steps of {}", control.minimum, control.maximum, control.step)
                              : fmt::format("{} to {}", control.minimum, control.maximum);
  }
}

/// The value as a number; nothing where the text is none that the control knows.
std::optional<std::int64_t> value_of(const V4l2Device& device, const v4l2_query_ext_ctrl& control,
                                     const std::string& text) {
  const std::string word = plain(text);
  switch (control.type) {
    case V4L2_CTRL_TYPE_BUTTON:
      return 1;
    case V4L2_CTRL_TYPE_BOOLEAN:
      if (word == "on" || word == "true" || word == "yes" || word == "1") return 1;
      if (word == "off" || word == "false" || word == "no" || word == "0") return 0;
      return std::nullopt;
    case V4L2_CTRL_TYPE_MENU:
    case V4L2_CTRL_TYPE_INTEGER_MENU: {
      const auto number = whole_number(text);
      for (const MenuEntry& entry : menu_of(device, control)) {
        if (entry.text == text || (!word.empty() && plain(entry.text) == word && !number) || number == entry.index)
          return entry.index;
      }
      return std::nullopt;
    }
    default: {
      const auto number = whole_number(text);
      if (!number ||
          (control.type != V4L2_CTRL_TYPE_BITMASK && (*number < control.minimum || *number > control.maximum)))
        return std::nullopt;
      return number;
    }
  }
}

[[noreturn]] void refuse(const V4l2Device& device, const v4l2_query_ext_ctrl& control, const std::string& text) {
  throw UsageError(fmt::format("{}: control '{}' does not take '{}' (allowed: {})", device.name(), name_of(control),
                               text, allowed_by(device, control)));
}

void set_control(const V4l2Device& device, const v4l2_query_ext_ctrl& control, const std::string& text) {
  if ((control.flags & V4L2_CTRL_FLAG_READ_ONLY) != 0)
    throw UsageError(fmt::format("{}: control '{}' can only be read", device.name(), name_of(control)));
  v4l2_ext_control value{};
  value.id = control.id;
  std::string characters = text;
  if (control.type == V4L2_CTRL_TYPE_STRING) {
    if (static_cast<std::int64_t>(text.size()) > control.maximum ||
        static_cast<std::int64_t>(text.size()) < control.minimum)
      refuse(device, control, text);
    characters.resize(control.elem_size, '\0');
    value.size = control.elem_size;
    value.string = characters.data();
  } else {
    const auto number = value_of(device, control, text);
    if (!number) refuse(device, control, text);
    if (control.type == V4L2_CTRL_TYPE_INTEGER64) {
      value.value64 = *number;
    } else {
      value.value = static_cast<std::int32_t>(*number);
    }
  }
  v4l2_ext_controls values{};
  values.which = V4L2_CTRL_WHICH_CUR_VAL;
  values.count = 1;
  values.controls = &value;
  const int error = device.call(VIDIOC_S_EXT_CTRLS, &values);
  if (error == ERANGE || error == EINVAL) refuse(device, control, text);
  if (error == EBUSY)
    throw UsageError(
        fmt::format("{}: control '{}' cannot be set now: another control rules it", device.name(), name_of(control)));
  if (error != 0) throw device.failure(fmt::format("control '{}' cannot be set", name_of(control)), error);
}

const v4l2_query_ext_ctrl* with_id(const std::vector<v4l2_query_ext_ctrl>& controls, std::uint32_t id) {
  const auto found =
      std::find_if(controls.begin(), controls.end(), [&](const auto& control) { return control.id == id; });
  return found == controls.end() ? nullptr : &*found;
}

void set_exposure(const V4l2Device& device, const std::vector<v4l2_query_ext_ctrl>& controls, double exposure_us) {
  constexpr double unit_us = 100.0;
  const auto* exposure = with_id(controls, V4L2_CID_EXPOSURE_ABSOLUTE);
  if (exposure == nullptr)
    throw UsageError(fmt::format(
        "{}: has no exposure time in microseconds; what it has is set by name, see v4l2-ctl -l", device.name()));
  if (const auto* automatic = with_id(controls, V4L2_CID_EXPOSURE_AUTO)) {
    // Some cameras know no manual mode, but one in which the time is given and the aperture follows.
    const auto modes = menu_of(device, *automatic);
    const auto has = [&](std::int64_t mode) {
      return std::any_of(modes.begin(), modes.end(), [&](const MenuEntry& entry) { return entry.index == mode; });
    };
    set_control(device, *automatic,
                std::to_string(has(V4L2_EXPOSURE_MANUAL) ? V4L2_EXPOSURE_MANUAL : V4L2_EXPOSURE_SHUTTER_PRIORITY));
  }
  const auto units = static_cast<std::int64_t>(std::llround(exposure_us / unit_us));
  if (units < exposure->minimum || units > exposure->maximum)
    throw UsageError(fmt::format(
        "{}: an exposure of {:.6g} µs is not possible (allowed: {:.6g} to {:.6g} µs in steps of {:.6g})", device.name(),
        exposure_us, unit_us * static_cast<double>(exposure->minimum), unit_us * static_cast<double>(exposure->maximum),
        unit_us * static_cast<double>(std::max<std::uint64_t>(exposure->step, 1))));
  set_control(device, *exposure, std::to_string(units));
}

void set_gain(const V4l2Device& device, const std::vector<v4l2_query_ext_ctrl>& controls, double gain) {
  const auto* control = with_id(controls, V4L2_CID_GAIN);
  if (control == nullptr) control = with_id(controls, V4L2_CID_ANALOGUE_GAIN);
  if (control == nullptr) throw UsageError(fmt::format("{}: has no gain that can be set", device.name()));
  if (const auto* automatic = with_id(controls, V4L2_CID_AUTOGAIN)) set_control(device, *automatic, "off");
  if (gain != std::round(gain)) refuse(device, *control, fmt::format("{:.6g}", gain));
  set_control(device, *control, std::to_string(std::llround(gain)));
}

}  // namespace

void set_controls(const V4l2Device& device, const CameraSettings& settings) {
  if (!settings.exposure_us && !settings.gain && settings.controls.empty()) return;
  const auto controls = controls_of(device);
  if (settings.exposure_us) set_exposure(device, controls, *settings.exposure_us);
  if (settings.gain) set_gain(device, controls, *settings.gain);
  for (const CameraControl& wanted : settings.controls) {
    const std::string word = plain(wanted.name);
    const auto found = std::find_if(controls.begin(), controls.end(),
                                    [&](const auto& control) { return plain(name_of(control)) == word; });
    if (found == controls.end()) {
      std::string allowed;
      for (const auto& control : controls) allowed += (allowed.empty() ? "'" : ", '") + name_of(control) + "'";
      throw UsageError(fmt::format("{}: has no control '{}' (allowed: {})", device.name(), wanted.name,
                                   allowed.empty() ? "none" : allowed));
    }
    set_control(device, *found, wanted.value);
  }
}

}  // namespace vsfind
