#include "acquisition/gige_camera.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>

#include "acquisition/errors.h"
#include "acquisition/network_path.h"

namespace vsfind::gige {
namespace {

bool is_available(ArvDevice* device, const char* feature) {
  CallError error;
  return arv_device_is_feature_available(device, feature, error.out()) != FALSE && !error;
}

std::string string_feature(ArvDevice* device, const char* feature) {
  if (!is_available(device, feature)) return "";
  CallError error;
  const char* const value = arv_device_get_string_feature_value(device, feature, error.out());
  return value != nullptr ? value : "";
}

class SettingUp {
 public:
  SettingUp(ArvCamera* camera, const std::string& uri, const CameraSettings& settings)
      : camera_(camera), device_(arv_camera_get_device(camera)), uri_(uri), settings_(settings) {}

  Setup run() {
    // The camera keeps what other programs set: what matters is set outright.
    CallError error;
    arv_camera_clear_triggers(camera_, error.out());
    if (error.is_of_connection()) check(error, uri_);
    if (is_available(device_, "AcquisitionMode")) {
      arv_camera_set_acquisition_mode(camera_, ARV_ACQUISITION_MODE_CONTINUOUS, error.out());
      check(error, uri_ + ": continuous acquisition");
    }
    pixel_format();
    region();
    frame_rate();
    exposure();
    gain();
    trigger();
    for (const auto& control : settings_.controls) set_feature(camera_, uri_, control);
    fields();
    packets();
    read_back();
    return setup_;
  }

 private:
  void pixel_format() {
    const std::vector<std::string> names = entries_of(device_, "PixelFormat");
    std::string wanted = settings_.pixel_format;
    if (wanted.empty() && std::find(names.begin(), names.end(), "Mono8") != names.end()) wanted = "Mono8";
    if (wanted.empty()) return;  // as the camera has it; read_back() sees whether luma can be had from it
    if (std::find(names.begin(), names.end(), wanted) == names.end())
      throw UsageError(
          fmt::format("{}: the pixel format '{}' is not known (allowed: {})", uri_, wanted, fmt::join(names, ", ")));
    CallError error;
    arv_camera_set_pixel_format_from_string(camera_, wanted.c_str(), error.out());
    check(error, fmt::format("{}: pixel format {}", uri_, wanted));
  }

  void side(const char* what, int value, int min, int max, int step) const {
    if (value >= min && value <= max && (step <= 1 || (value - min) % step == 0)) return;
    throw UsageError(fmt::format("{}: the {} {} is not possible (allowed: {} to {}, step {})", uri_, what, value, min,
                                 max, std::max(step, 1)));
  }

  void region() {
    if (settings_.width == 0 && settings_.height == 0 && !settings_.offset_x && !settings_.offset_y) return;
    CallError error;
    int x = 0;
    int y = 0;
    int width = 0;
    int height = 0;
    int min = 0;
    int max = 0;
    arv_camera_get_region(camera_, &x, &y, &width, &height, error.out());
    check(error, uri_ + ": region");
    // An offset left by another program would limit the size.
    if (arv_camera_is_region_offset_available(camera_, error.out()) != FALSE)
      arv_camera_set_region(camera_, 0, 0, -1, -1, error.out());
    if (settings_.width > 0) {
      arv_camera_get_width_bounds(camera_, &min, &max, error.out());
      side("width", settings_.width, min, max, arv_camera_get_width_increment(camera_, error.out()));
      width = settings_.width;
      x = 0;
    }
    if (settings_.height > 0) {
      arv_camera_get_height_bounds(camera_, &min, &max, error.out());
      side("height", settings_.height, min, max, arv_camera_get_height_increment(camera_, error.out()));
      height = settings_.height;
      y = 0;
    }
    arv_camera_set_region(camera_, -1, -1, width, height, error.out());
    check(error, fmt::format("{}: size {}x{}", uri_, width, height));
    if (settings_.offset_x) {
      x = *settings_.offset_x;
      arv_camera_get_x_offset_bounds(camera_, &min, &max, error.out());
      if (!error) side("left edge", x, min, max, arv_camera_get_x_offset_increment(camera_, error.out()));
    }
    if (settings_.offset_y) {
      y = *settings_.offset_y;
      arv_camera_get_y_offset_bounds(camera_, &min, &max, error.out());
      if (!error) side("top edge", y, min, max, arv_camera_get_y_offset_increment(camera_, error.out()));
    }
    arv_camera_set_region(camera_, x, y, width, height, error.out());
    check(error, fmt::format("{}: region {},{} {}x{}", uri_, x, y, width, height));
  }

  void frame_rate() {
    if (settings_.frame_rate <= 0.0) return;
    CallError error;
    if (arv_camera_is_frame_rate_available(camera_, error.out()) == FALSE)
      throw UsageError(fmt::format("{}: the camera's frame rate cannot be set", uri_));
    limits("frame rate", settings_.frame_rate, arv_camera_get_frame_rate_bounds, "Hz");
    arv_camera_set_frame_rate(camera_, settings_.frame_rate, error.out());
    check(error, fmt::format("{}: frame rate {} Hz", uri_, settings_.frame_rate));
  }

  void exposure() {
    if (!settings_.exposure_us) return;
    CallError error;
    if (arv_camera_is_exposure_time_available(camera_, error.out()) == FALSE)
      throw UsageError(fmt::format("{}: the camera's exposure time cannot be set", uri_));
    if (arv_camera_is_exposure_auto_available(camera_, error.out()) != FALSE) {
      arv_camera_set_exposure_time_auto(camera_, ARV_AUTO_OFF, error.out());
      check(error, uri_ + ": automatic exposure off");
    }
    limits("exposure", *settings_.exposure_us, arv_camera_get_exposure_time_bounds, "us");
    arv_camera_set_exposure_time(camera_, *settings_.exposure_us, error.out());
    check(error, fmt::format("{}: exposure {} us", uri_, *settings_.exposure_us));
  }

  void gain() {
    if (!settings_.gain) return;
    CallError error;
    if (arv_camera_is_gain_available(camera_, error.out()) == FALSE)
      throw UsageError(fmt::format("{}: the camera's gain cannot be set", uri_));
    if (arv_camera_is_gain_auto_available(camera_, error.out()) != FALSE) {
      arv_camera_set_gain_auto(camera_, ARV_AUTO_OFF, error.out());
      check(error, uri_ + ": automatic gain off");
    }
    limits("gain", *settings_.gain, arv_camera_get_gain_bounds, "");
    arv_camera_set_gain(camera_, *settings_.gain, error.out());
    check(error, fmt::format("{}: gain {}", uri_, *settings_.gain));
  }

  void limits(const char* what, double value, void (*bounds)(ArvCamera*, double*, double*, GError**),
              const char* unit) const {
    double min = 0.0;
    double max = 0.0;
    CallError error;
    bounds(camera_, &min, &max, error.out());
    if (error || (value >= min && value <= max)) return;
    throw UsageError(fmt::format("{}: the {} {} is out of range (allowed: {:g} to {:g}{}{})", uri_, what, value, min,
                                 max, *unit != '\0' ? " " : "", unit));
  }

  void trigger() {
    const std::string& wanted = settings_.trigger;
    if (wanted.empty() || wanted == "off") return;
    const std::vector<std::string> sources = entries_of(device_, "TriggerSource");
    setup_.software_trigger = wanted == "software" || wanted == "Software";
    setup_.hardware_trigger = !setup_.software_trigger;
    const std::string name = setup_.software_trigger ? "Software" : wanted;
    if (std::find(sources.begin(), sources.end(), name) == sources.end())
      throw UsageError(
          fmt::format("{}: the trigger '{}' is not known (allowed: off, {})", uri_, wanted, fmt::join(sources, ", ")));
    CallError error;
    arv_camera_set_trigger(camera_, name.c_str(), error.out());
    check(error, fmt::format("{}: trigger {}", uri_, name));
  }

  /// The largest packets that the path carries: larger ones arrive in pieces, or wrong without a sign of it.
  void packets() {
    const std::string address = address_of(camera_);
    const auto path = path_to(address);
    const int mtu = path ? path->mtu : 0;
    CallError error;
    int size = settings_.packet_size;
    if (size > 0 && mtu > 0 && size > mtu)
      throw UsageError(fmt::format("{}: packets of {} bytes do not fit into the {} bytes of {} (allowed: up to {})",
                                   uri_, size, mtu, path->interface, mtu));
    if (size == 0 && is_available(device_, "GevSCPSFireTestPacket")) {
      size = static_cast<int>(arv_camera_gv_auto_packet_size(camera_, error.out()));  // tries which ones arrive
      if (error) size = 0;
      if (mtu > 0) size = std::min(size, mtu);
    }
    if (size == 0) {
      // Without a trial only what every network carries, or what never leaves this machine.
      constexpr int ethernet = 1500;
      constexpr int local = 9000;
      size = path && path->loopback ? std::min(local, mtu) : std::min(ethernet, mtu > 0 ? mtu : ethernet);
    }
    arv_camera_gv_set_packet_size(camera_, size, error.out());
    check(error, fmt::format("{}: packet size {}", uri_, size));
    arv_camera_gv_set_packet_size_adjustment(camera_, ARV_GV_PACKET_SIZE_ADJUSTMENT_NEVER);  // done

    // Past the kernel's UDP only where the frames really come in at the interface that Aravis listens on: at another
    // one none would arrive, without an error.
    GSocketAddress* const listening = arv_gv_device_get_interface_address(ARV_GV_DEVICE(device_));
    const std::unique_ptr<char, Free> own(
        g_inet_address_to_string(g_inet_socket_address_get_address(G_INET_SOCKET_ADDRESS(listening))));
    const bool is_the_path = path && path->address == own.get() && (!path->loopback || path->interface == "lo");
    const bool wanted = settings_.packet_socket.value_or(is_the_path);
    if (wanted && !is_the_path) {
      throw UsageError(
          fmt::format("{}: a packet socket would not see the frames: they do not come in at {}", uri_, own.get()));
    }
    arv_camera_gv_set_stream_options(camera_,
                                     wanted ? ARV_GV_STREAM_OPTION_NONE : ARV_GV_STREAM_OPTION_PACKET_SOCKET_DISABLED);
    spdlog::info("{}: at {}, packets of {} bytes, packet socket {}", uri_, address, size,
                 wanted ? "where permitted" : "off");
  }

  void read_back() {
    CallError error;
    int x = 0;
    int y = 0;
    arv_camera_get_region(camera_, &x, &y, &setup_.width, &setup_.height, error.out());
    check(error, uri_ + ": size");
    const auto format = static_cast<std::uint32_t>(arv_camera_get_pixel_format(camera_, error.out()));
    check(error, uri_ + ": pixel format");
    const auto pixels = gige_pixels(format);
    if (!pixels) {
      const char* const name = arv_camera_get_pixel_format_as_string(camera_, error.out());
      throw UsageError(fmt::format("{}: luma cannot be had from the pixel format {} (allowed of the camera's: {})",
                                   uri_, name != nullptr ? name : "", fmt::join(usable_formats(), ", ")));
    }
    setup_.pixels = *pixels;
    setup_.payload = arv_camera_get_payload(camera_, error.out());
    check(error, uri_ + ": payload");
    constexpr std::size_t max_payload = std::size_t{1} << 30;
    if (setup_.width < 1 || setup_.height < 1 || setup_.payload < 1 || setup_.payload > max_payload)
      throw CameraError(fmt::format("{}: says that its pictures have {}x{} pixels and {} bytes", uri_, setup_.width,
                                    setup_.height, setup_.payload));
    if (arv_camera_is_frame_rate_available(camera_, error.out()) != FALSE && !setup_.hardware_trigger)
      setup_.frame_rate = arv_camera_get_frame_rate(camera_, error.out());
    if (setup_.fields == Fields::concatenated && setup_.height % 2 != 0)
      throw UsageError(
          fmt::format("{}: two fields cannot lie in {} rows (allowed: an even number)", uri_, setup_.height));
  }

  std::vector<std::string> usable_formats() {
    guint count = 0;
    CallError error;
    const std::unique_ptr<gint64, Free> numbers(arv_camera_dup_available_pixel_formats(camera_, &count, error.out()));
    std::vector<std::string> usable;
    for (guint i = 0; numbers && i < count; ++i) {
      const std::string name = gige_pixel_format_name(static_cast<std::uint32_t>(numbers.get()[i]));
      if (!name.empty()) usable.push_back(name);
    }
    return usable;
  }

  /// The leader's own field bits do not reach us: the mode that the camera is set to has to tell.
  void fields() {
    const std::string mode = string_feature(device_, "FieldOutputMode");
    if (mode.empty() || string_feature(device_, "DeviceScanType").find("rogressive") != std::string::npos) return;
    const std::string& order = settings_.field_order;
    if (!order.empty() && order != "interlaced-tb" && order != "interlaced-bt")
      throw UsageError(fmt::format("{}: the field order '{}' is not known here (allowed: interlaced-tb, interlaced-bt)",
                                   uri_, order));
    const FieldOrder both = order == "interlaced-bt" ? FieldOrder::bottom_first : FieldOrder::top_first;
    if (mode == "DeinterlacedNewFields") {
      setup_.fields = Fields::woven;
      setup_.order = both;
    } else if (mode == "ConcatenatedNewFields") {
      setup_.fields = Fields::concatenated;
      setup_.order = both;
    } else if (mode == "Field0") {
      setup_.fields = Fields::top;
      setup_.order = both;
    } else if (mode == "Field1") {
      setup_.fields = Fields::bottom;
      setup_.order = both;
    } else if (mode == "Field0First") {
      setup_.fields = Fields::in_turn;
      setup_.order = both;
    } else {
      throw UsageError(
          fmt::format("{}: what fields lie in a picture with FieldOutputMode {} is not known (allowed: "
                      "ConcatenatedNewFields, DeinterlacedNewFields, Field0, Field1, Field0First)",
                      uri_, mode));
    }
    if (is_single(setup_.fields)) field_size();
  }

  /// The size asked for is that of a whole frame, of which a field has half the rows.
  void field_size() {
    if (settings_.height <= 0) return;
    if (settings_.height % 2 != 0)
      throw UsageError(
          fmt::format("{}: two fields cannot lie in {} rows (allowed: an even number)", uri_, settings_.height));
    CallError error;
    arv_camera_set_region(camera_, -1, -1, -1, settings_.height / 2, error.out());
    check(error, fmt::format("{}: fields of {} rows", uri_, settings_.height / 2));
  }

  ArvCamera* camera_;
  ArvDevice* device_;
  const std::string& uri_;
  const CameraSettings& settings_;
  Setup setup_;
};

}  // namespace

Setup set_up(ArvCamera* camera, const std::string& uri, const CameraSettings& settings) {
  return SettingUp(camera, uri, settings).run();
}

}  // namespace vsfind::gige
