#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

#include "acquisition/errors.h"
#include "acquisition/gige_camera.h"

namespace vsfind::gige {

void check(const CallError& error, const std::string& what) {
  if (!error) return;
  const std::string text = fmt::format("{}: {}", what, error.text());
  if (error.is_of_connection()) throw CameraError(text);
  throw UsageError(text);
}

std::vector<std::string> entries_of(ArvDevice* device, const char* feature) {
  std::vector<std::string> entries;
  guint count = 0;
  CallError error;
  const StringList list(
      arv_device_dup_available_enumeration_feature_values_as_strings(device, feature, &count, error.out()));
  for (guint i = 0; list && i < count; ++i) entries.emplace_back(list.get()[i]);
  return entries;
}

namespace {

double number_of(const std::string& text, const std::string& where, bool whole) {
  char* end = nullptr;
  const double value = g_ascii_strtod(text.c_str(), &end);
  const bool hexadecimal = text.starts_with("0x") || text.starts_with("0X");
  if (text.empty() || *end != '\0' || !std::isfinite(value) || (whole && !hexadecimal && value != std::floor(value)))
    throw UsageError(fmt::format("{}: '{}' is not a {}number", where, text, whole ? "whole " : ""));
  return value;
}

template <typename T>
void check_bounds(T value, T min, T max, const CallError& error, const std::string& where) {
  if (error || (value >= min && value <= max)) return;
  throw UsageError(fmt::format("{}: {} is out of range (allowed: {} to {})", where, value, min, max));
}

}  // namespace

void set_feature(ArvCamera* camera, const std::string& uri, const CameraControl& control) {
  ArvDevice* const device = arv_camera_get_device(camera);
  const char* const name = control.name.c_str();
  const std::string where = fmt::format("{}: feature {}", uri, control.name);
  ArvGcNode* const node = arv_device_get_feature(device, name);
  if (node == nullptr || !ARV_IS_GC_FEATURE_NODE(node))
    throw UsageError(fmt::format("{}: the camera does not have it (arv-tool-0.8 features lists them all)", where));
  CallError error;
  if (ARV_IS_GC_COMMAND(node)) {
    arv_device_execute_command(device, name, error.out());
  } else if (ARV_IS_GC_ENUMERATION(node)) {
    const auto entries = entries_of(device, name);
    if (std::find(entries.begin(), entries.end(), control.value) == entries.end())
      throw UsageError(
          fmt::format("{}: '{}' is not known (allowed: {})", where, control.value, fmt::join(entries, ", ")));
    arv_device_set_string_feature_value(device, name, control.value.c_str(), error.out());
  } else if (ARV_IS_GC_BOOLEAN(node)) {
    const std::string& value = control.value;
    const bool on = value == "true" || value == "on" || value == "yes" || value == "1";
    if (!on && value != "false" && value != "off" && value != "no" && value != "0")
      throw UsageError(fmt::format("{}: '{}' is not known (allowed: true, false)", where, value));
    arv_device_set_boolean_feature_value(device, name, on ? TRUE : FALSE, error.out());
  } else if (ARV_IS_GC_STRING(node)) {
    arv_device_set_string_feature_value(device, name, control.value.c_str(), error.out());
  } else if (ARV_IS_GC_FLOAT(node)) {
    const double value = number_of(control.value, where, false);
    double min = 0.0;
    double max = 0.0;
    arv_device_get_float_feature_bounds(device, name, &min, &max, error.out());
    check_bounds(value, min, max, error, where);
    arv_device_set_float_feature_value(device, name, value, error.out());
  } else if (ARV_IS_GC_INTEGER(node)) {
    static_cast<void>(number_of(control.value, where, true));
    const gint64 value = std::strtoll(control.value.c_str(), nullptr, 0);
    gint64 min = 0;
    gint64 max = 0;
    arv_device_get_integer_feature_bounds(device, name, &min, &max, error.out());
    check_bounds(value, min, max, error, where);
    arv_device_set_integer_feature_value(device, name, value, error.out());
  } else {
    throw UsageError(fmt::format("{}: is of a kind that cannot be set", where));
  }
  check(error, fmt::format("{}: cannot be set to '{}'", where, control.value));
}

}  // namespace vsfind::gige
