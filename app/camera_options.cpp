#include "app/camera_options.h"

#include <optional>
#include <tuple>
#include <utility>

namespace vsfind {
namespace {

/// `A` `separator` `B` in whole numbers.
std::pair<int, int> parse_pair(const std::string& text, char separator, int min, int max, const std::string& form) {
  const auto at = text.find(separator);
  if (at == std::string::npos) throw ValueError("'" + text + "' is not " + form);
  return {parse_whole(text.substr(0, at), min, max), parse_whole(text.substr(at + 1), min, max)};
}

CameraControl parse_control(const std::string& text) {
  const auto at = text.find('=');
  if (at == std::string::npos || at == 0) throw ValueError("'" + text + "' is not NAME=VALUE");
  return {text.substr(0, at), text.substr(at + 1)};
}

}  // namespace

std::vector<Setting> camera_settings(CameraSettings& camera) {
  CameraSettings* const c = &camera;
  using Values = const std::vector<std::string>&;
  constexpr int max_side = 65536;
  constexpr int max_bytes = 1 << 30;
  constexpr double max_seconds = 1e6;
  std::vector<Setting> settings;
  const auto add = [&settings](std::string name, std::string value, std::string help, auto set) -> Setting& {
    return settings.emplace_back(Setting{std::move(name), std::move(value), std::move(help), std::move(set)});
  };

  add("size", "WxH", "Camera: pixels and rows of a whole frame (default: as the camera is set)",
      [c](Values v) { std::tie(c->width, c->height) = parse_pair(v[0], 'x', 1, max_side, "WxH"); });
  add("offset", "X,Y", "Camera: left upper corner of the part of the sensor that is read out, pixels", [c](Values v) {
    std::tie(c->offset_x, c->offset_y) = parse_pair(v[0], ',', 0, max_side, "X,Y");
  }).separator = ',';
  add("pixel-format", "NAME", "Camera: as it calls it: Mono8, GREY, YUYV, … (default: the best for luma)",
      [c](Values v) { c->pixel_format = v[0]; });
  add("frame-rate", "HZ", "Camera: frames per second",
      [c](Values v) { c->frame_rate = parse_number(v[0], 1e-3, 1e6); });
  add("exposure", "US", "Camera: exposure time, microseconds; without automatic exposure",
      [c](Values v) { c->exposure_us = parse_number(v[0], 0.0, 1e9); });
  add("gain", "VALUE", "Camera: gain in its own unit; without automatic gain",
      [c](Values v) { c->gain = parse_number(v[0], -1e6, 1e6); });
  add("control", "NAME=VALUE", "Camera: any control or GenICam feature by its name (repeatable, in this order)",
      [c](Values values) {
        c->controls.clear();
        for (const auto& value : values) c->controls.push_back(parse_control(value));
      });
  settings.back().repeatable = true;
  settings.back().pairs = true;
  add("trigger", "off|software|LINE", "GigE: what starts a frame; LINE as the camera calls it: Line1 (default off)",
      [c](Values v) { c->trigger = v[0]; });
  add("trigger-rate", "HZ", "GigE: software triggers per second (default: one as soon as a frame has come)",
      [c](Values v) { c->trigger_rate = parse_number(v[0], 1e-3, 1e4); });
  add("input", "NAME|N", "V4L2: the input, by its name or number", [c](Values v) { c->input = v[0]; });
  add("standard", "NAME", "V4L2: the video standard: PAL, NTSC, …", [c](Values v) { c->standard = v[0]; });
  add("field-order", "NAME",
      "V4L2: how fields are asked for: interlaced, alternate, seq-tb, top, none, …; GigE: interlaced-bt where the "
      "bottom "
      "field is the earlier one, or interlaced-tb",
      [c](Values v) { c->field_order = v[0]; });
  add("buffers", "N", "Camera: buffers that wait for frames, 4 to 64 (default 8)",
      [c](Values v) { c->buffers = parse_whole(v[0], 4, 64); });
  add("frame-timeout", "S", "Camera: no frame for so many seconds is a fault; 0: never (default 2)",
      [c](Values v) { c->frame_timeout_s = parse_number(v[0], 0.0, max_seconds); });
  add("packet-size", "BYTES", "GigE: size of a packet (default: the largest that the path carries)",
      [c](Values v) { c->packet_size = parse_whole(v[0], 0, 65535); });
  add("socket-buffer", "BYTES", "GigE: the kernel's receive buffer (default: sized to the frames)",
      [c](Values v) { c->socket_buffer = parse_whole(v[0], 0, max_bytes); });
  add("packet-socket", "auto|on|off", "GigE: receive past the kernel's UDP; wants root or CAP_NET_RAW (default auto)",
      [c](Values v) {
        c->packet_socket =
            parse_word<std::optional<bool>>(v[0], {{"auto", std::nullopt}, {"on", true}, {"off", false}});
      });
  add("packet-resend", "on|off", "GigE: ask for lost packets again (default on)", [c](Values v) {
    c->packet_resend = parse_word<bool>(v[0], {{"on", true}, {"off", false}});
  });
  return settings;
}

}  // namespace vsfind
