#include "app/camera_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "acquisition/timestamp.h"

namespace vsfind {
namespace {

bool is_fixed(const CameraSizes& size) {
  return size.min_width == size.max_width && size.min_height == size.max_height;
}

/// Of many sizes only the ends.
std::string sizes_text(const std::vector<CameraSizes>& sizes) {
  constexpr std::size_t listed = 4;
  const auto one = [](const CameraSizes& size) {
    const std::string smallest = fmt::format("{}x{}", size.min_width, size.min_height);
    return size.step_x == 0 && size.step_y == 0 ? smallest
                                                : fmt::format("{} to {}x{}", smallest, size.max_width, size.max_height);
  };
  if (sizes.empty()) return {};
  std::string text;
  if (sizes.size() > listed) {
    const auto area = [](const CameraSizes& a, const CameraSizes& b) {
      return std::int64_t{a.max_width} * a.max_height < std::int64_t{b.max_width} * b.max_height;
    };
    const auto [smallest, largest] = std::minmax_element(sizes.begin(), sizes.end(), area);
    text = fmt::format("{} … {} ({} sizes)", one(*smallest), one(*largest), sizes.size());
  } else {
    for (const CameraSizes& size : sizes) text += (text.empty() ? "" : ", ") + one(size);
  }
  double slowest = 0.0;
  double fastest = 0.0;
  for (const CameraSizes& size : sizes) {
    for (const double rate : size.rates) {
      slowest = slowest == 0.0 ? rate : std::min(slowest, rate);
      fastest = std::max(fastest, rate);
    }
  }
  if (fastest <= 0.0) return text;
  return text + (slowest < fastest ? fmt::format(" at {:.4g} to {:.4g}/s", slowest, fastest)
                                   : fmt::format(" at {:.4g}/s", fastest));
}

/// Formats of the same sizes together; those whose luma must be converted only counted.
std::string formats_text(const std::vector<CameraFormat>& formats) {
  std::vector<std::pair<std::string, std::string>> groups;  // sizes, names
  std::size_t converted = 0;
  const bool any_direct = std::any_of(formats.begin(), formats.end(), [](const auto& format) { return format.direct; });
  for (const CameraFormat& format : formats) {
    if (any_direct && !format.direct) {
      ++converted;
      continue;
    }
    const std::string sizes = sizes_text(format.sizes);
    const auto group =
        std::find_if(groups.begin(), groups.end(), [&](const auto& known) { return known.first == sizes; });
    if (group == groups.end()) {
      groups.emplace_back(sizes, format.name);
    } else {
      group->second += "," + format.name;
    }
  }
  std::string text;
  for (const auto& [sizes, names] : groups)
    text += fmt::format("{}{}{}{}", text.empty() ? "" : "; ", names, sizes.empty() ? "" : " ", sizes);
  if (converted > 0) text += fmt::format("; {} formats more, converted", converted);
  return text;
}

nlohmann::ordered_json sizes_json(const CameraSizes& size) {
  nlohmann::ordered_json json;
  if (is_fixed(size)) {
    json["width"] = size.min_width;
    json["height"] = size.min_height;
  } else {
    json["width"] = {{"min", size.min_width}, {"max", size.max_width}, {"step", size.step_x}};
    json["height"] = {{"min", size.min_height}, {"max", size.max_height}, {"step", size.step_y}};
  }
  if (size.rates_are_range && size.rates.size() == 2) {
    const auto [slowest, fastest] = std::minmax(size.rates[0], size.rates[1]);
    json["rates"] = {{"min", slowest}, {"max", fastest}};
  } else {
    json["rates"] = size.rates;
  }
  return json;
}

}  // namespace

std::string camera_line(const CameraDescription& camera) {
  std::string model = camera.vendor;
  if (!camera.model.empty() && camera.model != model) model += (model.empty() ? "" : " ") + camera.model;
  std::string line = fmt::format("{}  {}  serial {}", camera.uri, model.empty() ? "-" : model,
                                 camera.serial.empty() ? "-" : camera.serial);
  if (!camera.address.empty()) line += "  at " + camera.address;
  if (const std::string formats = formats_text(camera.formats); !formats.empty()) line += "  " + formats;
  if (camera.clock != Clock::none) line += "  " + timestamp_text(camera.clock, camera.stamped_at);
  if (!camera.problem.empty()) line += "  (" + camera.problem + ")";
  // What a device says of itself may hold anything.
  for (char& c : line) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
  return line;
}

std::string cameras_json(const std::vector<CameraDescription>& cameras) {
  auto json = nlohmann::ordered_json::array();
  for (const CameraDescription& camera : cameras) {
    nlohmann::ordered_json one;
    one["uri"] = camera.uri;
    one["vendor"] = camera.vendor;
    one["model"] = camera.model;
    one["serial"] = camera.serial;
    one["address"] = camera.address;
    one["timestamps"] = {{"clock", name(camera.clock)}, {"of", name(camera.stamped_at)}};
    one["problem"] = camera.problem;
    one["formats"] = nlohmann::ordered_json::array();
    for (const CameraFormat& format : camera.formats) {
      nlohmann::ordered_json entry;
      entry["name"] = format.name;
      entry["description"] = format.description;
      entry["direct"] = format.direct;
      entry["sizes"] = nlohmann::ordered_json::array();
      for (const CameraSizes& size : format.sizes) entry["sizes"].push_back(sizes_json(size));
      one["formats"].push_back(std::move(entry));
    }
    json.push_back(std::move(one));
  }
  constexpr int indent = 2;
  return json.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace vsfind
