#include <fmt/format.h>

#include <map>
#include <mutex>

#include "acquisition/errors.h"
#include "acquisition/gige_camera.h"
#include "acquisition/gige_source.h"
#include "acquisition/network_path.h"

namespace vsfind {
namespace gige {
namespace {

std::string text_or_empty(const char* text) { return text != nullptr ? text : ""; }

/// Which of Aravis' names a serial number belongs to: learnt once, so that a camera that comes back is found as
/// quickly by its serial number as by its name.
class LearntNames {
 public:
  [[nodiscard]] std::string of(const std::string& serial) {
    const std::lock_guard lock(mutex_);
    const auto place = names_.find(serial);
    return place == names_.end() ? "" : place->second;
  }
  void learn(const std::string& serial, const std::string& name) {
    const std::lock_guard lock(mutex_);
    names_[serial] = name;
  }

 private:
  std::mutex mutex_;
  std::map<std::string, std::string> names_;
};

LearntNames& learnt_names() {
  static LearntNames names;
  return names;
}

std::vector<std::string> discovered() {
  arv_update_device_list();
  std::vector<std::string> ids;
  for (unsigned i = 0; i < arv_get_n_devices(); ++i) ids.push_back(text_or_empty(arv_get_device_id(i)));
  return ids;
}

ObjectPtr<ArvCamera> open_by_id(const std::string& id, CallError& error) {
  return ObjectPtr<ArvCamera>(arv_camera_new(id.c_str(), error.out()));
}

/// Without discovery, from the interface that the kernel's routes say.
ObjectPtr<ArvCamera> open_by_address(const std::string& uri, const std::string& address) {
  const auto path = path_to(address);
  if (!path) throw CameraError(fmt::format("{}: there is no route to {}", uri, address));
  const ObjectPtr<GInetAddress> here(g_inet_address_new_from_string(path->address.c_str()));
  const ObjectPtr<GInetAddress> there(g_inet_address_new_from_string(address.c_str()));
  CallError error;
  const ObjectPtr<ArvDevice> device(arv_gv_device_new(here.get(), there.get(), error.out()));
  if (!device) throw CameraError(fmt::format("{}: no camera answers: {}", uri, error.text()));
  ObjectPtr<ArvCamera> camera(arv_camera_new_with_device(device.get(), error.out()));
  if (!camera) throw CameraError(fmt::format("{}: cannot be opened: {}", uri, error.text()));
  return camera;
}

ObjectPtr<ArvCamera> open_by_name(const std::string& uri, const std::string& name) {
  CallError error;
  const std::string learnt = learnt_names().of(name);
  if (ObjectPtr<ArvCamera> camera = open_by_id(learnt.empty() ? name : learnt, error)) return camera;
  if (!learnt.empty()) throw CameraError(fmt::format("{}: no camera answers to this serial number", uri));
  const std::vector<std::string> ids = discovered();
  for (unsigned i = 0; i < ids.size(); ++i) {
    if (text_or_empty(arv_get_device_serial_nbr(i)) != name) continue;
    ObjectPtr<ArvCamera> camera = open_by_id(ids[i], error);
    if (!camera) throw CameraError(fmt::format("{}: cannot be opened: {}", uri, error.text()));
    learnt_names().learn(name, ids[i]);
    return camera;
  }
  throw CameraError(fmt::format("{}: no camera answers to this name (there are: {})", uri,
                                ids.empty() ? "none" : fmt::format("{}", fmt::join(ids, ", "))));
}

ObjectPtr<ArvCamera> open_first(const std::string& uri) {
  const std::vector<std::string> ids = discovered();
  if (ids.empty()) throw CameraError(fmt::format("{}: no GigE camera answers", uri));
  CallError error;
  ObjectPtr<ArvCamera> camera = open_by_id(ids.front(), error);
  if (!camera) throw CameraError(fmt::format("{}: {} cannot be opened: {}", uri, ids.front(), error.text()));
  return camera;
}

}  // namespace

std::unique_lock<std::mutex> lock_opening() {
  static std::mutex mutex;
  return std::unique_lock(mutex);
}

void use_gige_only() {
  static std::once_flag once;
  std::call_once(once, [] {
    for (unsigned i = 0; i < arv_get_n_interfaces(); ++i) {
      const std::string interface = text_or_empty(arv_get_interface_id(i));
      if (interface != "GigEVision") arv_disable_interface(interface.c_str());
    }
  });
}

ObjectPtr<ArvCamera> find_camera(const std::string& uri, const std::string& name) {
  use_gige_only();
  ObjectPtr<ArvCamera> camera = name.empty()            ? open_first(uri)
                                : is_ipv4_address(name) ? open_by_address(uri, name)
                                                        : open_by_name(uri, name);
  ArvDevice* const device = arv_camera_get_device(camera.get());
  if (!ARV_IS_GV_DEVICE(device)) throw CameraError(fmt::format("{}: is not a GigE camera", uri));
  // A second client opens well, and would only fail when it wants frames.
  if (!arv_gv_device_is_controller(ARV_GV_DEVICE(device)))
    throw CameraError(fmt::format("{}: another program holds the camera", uri));
  return camera;
}

std::string address_of(ArvCamera* camera) {
  GSocketAddress* const address = arv_gv_device_get_device_address(ARV_GV_DEVICE(arv_camera_get_device(camera)));
  if (!G_IS_INET_SOCKET_ADDRESS(address)) return "";
  const std::unique_ptr<char, Free> text(
      g_inet_address_to_string(g_inet_socket_address_get_address(G_INET_SOCKET_ADDRESS(address))));
  return text_or_empty(text.get());
}

namespace {

CameraSizes sizes_of(ArvCamera* camera) {
  CameraSizes sizes;
  CallError error;
  arv_camera_get_width_bounds(camera, &sizes.min_width, &sizes.max_width, error.out());
  arv_camera_get_height_bounds(camera, &sizes.min_height, &sizes.max_height, error.out());
  sizes.step_x = arv_camera_get_width_increment(camera, error.out());
  sizes.step_y = arv_camera_get_height_increment(camera, error.out());
  if (arv_camera_is_frame_rate_available(camera, error.out()) != FALSE) {
    double min = 0.0;
    double max = 0.0;
    arv_camera_get_frame_rate_bounds(camera, &min, &max, error.out());
    constexpr double highest = 1e6;  // beyond it no bound is known
    if (!error && max > 0.0 && max < highest) {
      sizes.rates = {min, max};
      sizes.rates_are_range = true;
    }
  }
  return sizes;
}

void describe(CameraDescription& description) {
  CallError error;
  const ObjectPtr<ArvCamera> camera = open_by_id(description.uri.substr(description.uri.find(':') + 1), error);
  if (!camera) {
    description.problem = error.text();
    return;
  }
  ArvDevice* const device = arv_camera_get_device(camera.get());
  if (!ARV_IS_GV_DEVICE(device) || !arv_gv_device_is_controller(ARV_GV_DEVICE(device)))
    description.problem = "held by another program";
  const CameraSizes sizes = sizes_of(camera.get());
  guint count = 0;
  const std::unique_ptr<gint64, Free> formats(
      arv_camera_dup_available_pixel_formats(camera.get(), &count, error.out()));
  const std::vector<std::string> names = entries_of(device, "PixelFormat");
  for (guint i = 0; formats && i < count; ++i) {
    const auto number = static_cast<std::uint32_t>(formats.get()[i]);
    const auto pixels = gige_pixels(number);
    CameraFormat format;
    format.name = names.size() == count ? names[i] : gige_pixel_format_name(number);
    format.direct = pixels && pixels->direct();
    format.description = format.direct ? "luma" : pixels ? "converted to luma" : "not supported";
    format.sizes.push_back(sizes);
    description.formats.push_back(std::move(format));
  }
  description.clock = Clock::device;  // which moment it tells is each maker's own
}

}  // namespace
}  // namespace gige

std::vector<CameraDescription> list_gige(bool details) {
  using namespace gige;
  const auto lock = lock_opening();
  use_gige_only();
  std::vector<CameraDescription> cameras;
  for (const std::string& id : discovered()) {
    const auto i = static_cast<unsigned>(cameras.size());
    CameraDescription camera;
    camera.uri = "gige:" + id;
    camera.vendor = text_or_empty(arv_get_device_vendor(i));
    camera.model = text_or_empty(arv_get_device_model(i));
    camera.serial = text_or_empty(arv_get_device_serial_nbr(i));
    camera.address = text_or_empty(arv_get_device_address(i));
    cameras.push_back(std::move(camera));
  }
  if (details) {
    for (auto& camera : cameras) describe(camera);
  }
  return cameras;
}

}  // namespace vsfind
