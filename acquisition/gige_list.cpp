#include <arv.h>

#include <cstring>
#include <memory>

#include "acquisition/gige_source.h"

namespace vsfind {
namespace {

struct Release {
  void operator()(void* object) const noexcept { g_object_unref(object); }
};

/// A place for an error that is of no interest: what cannot be asked for is left out.
class Ignored {
 public:
  Ignored() = default;
  Ignored(const Ignored&) = delete;
  Ignored& operator=(const Ignored&) = delete;
  ~Ignored() { g_clear_error(&error_); }
  [[nodiscard]] GError** to() {
    g_clear_error(&error_);
    return &error_;
  }
  [[nodiscard]] bool is_set() const { return error_ != nullptr; }

 private:
  GError* error_ = nullptr;
};

std::string text_of(const char* text) { return text == nullptr ? std::string() : std::string(text); }

/// Luma of these is read without looking at colour.
bool is_mono(const std::string& format) { return format.starts_with("Mono"); }

CameraSizes sizes_of(ArvCamera* camera) {
  CameraSizes sizes;
  Ignored error;
  arv_camera_get_width_bounds(camera, &sizes.min_width, &sizes.max_width, error.to());
  arv_camera_get_height_bounds(camera, &sizes.min_height, &sizes.max_height, error.to());
  sizes.step_x = sizes.max_width > sizes.min_width ? arv_camera_get_width_increment(camera, error.to()) : 0;
  sizes.step_y = sizes.max_height > sizes.min_height ? arv_camera_get_height_increment(camera, error.to()) : 0;
  double slowest = 0.0;
  double fastest = 0.0;
  arv_camera_get_frame_rate_bounds(camera, &slowest, &fastest, error.to());
  if (!error.is_set() && fastest > 0.0) {
    sizes.rates = {fastest, slowest};
    sizes.rates_are_range = true;
  }
  return sizes;
}

void add_formats(ArvCamera* camera, CameraDescription& description) {
  Ignored error;
  guint count = 0;
  const std::unique_ptr<const char*, decltype(&g_free)> names(
      arv_camera_dup_available_pixel_formats_as_strings(camera, &count, error.to()), g_free);
  if (!names) return;
  const CameraSizes sizes = sizes_of(camera);  // the same for all
  for (guint i = 0; i < count; ++i) {
    CameraFormat format;
    format.name = text_of(names.get()[i]);
    format.direct = is_mono(format.name);
    format.sizes.push_back(sizes);
    description.formats.push_back(std::move(format));
  }
}

}  // namespace

std::vector<CameraDescription> list_gige(bool details) {
  std::vector<CameraDescription> cameras;
  arv_update_device_list();
  const unsigned count = arv_get_n_devices();
  for (unsigned i = 0; i < count; ++i) {
    if (std::strcmp(text_of(arv_get_device_protocol(i)).c_str(), "GigEVision") != 0) continue;
    CameraDescription description;
    const std::string id = text_of(arv_get_device_id(i));
    description.uri = "gige:" + id;
    description.vendor = text_of(arv_get_device_vendor(i));
    description.model = text_of(arv_get_device_model(i));
    description.serial = text_of(arv_get_device_serial_nbr(i));
    description.address = text_of(arv_get_device_address(i));
    if (details) {
      Ignored error;
      const std::unique_ptr<ArvCamera, Release> camera(arv_camera_new(id.c_str(), error.to()));
      if (!camera) {
        description.problem = "does not answer";
      } else {
        add_formats(camera.get(), description);
        ArvDevice* device = arv_camera_get_device(camera.get());
        if (ARV_IS_GV_DEVICE(device) && arv_gv_device_is_controller(ARV_GV_DEVICE(device)) == FALSE)
          description.problem = "held by another program";
      }
    }
    cameras.push_back(std::move(description));
  }
  return cameras;
}

}  // namespace vsfind
