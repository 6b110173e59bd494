#pragma once
/// @file
/// A GigE camera found on the network and set up, not yet streaming. Included by the gige_*.cpp files only.

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/camera.h"
#include "acquisition/gige_glib.h"
#include "acquisition/gige_pixels.h"

namespace vsfind::gige {

/// Held while cameras are opened, described and closed: Aravis builds and frees their descriptions without locks of its
/// own, and two at once damage each other.
[[nodiscard]] std::unique_lock<std::mutex> lock_opening();

/// Makes Aravis look for GigE cameras only. Called before anything else of it.
void use_gige_only();

/// Finds the camera that `name` means and takes control of it. `uri` is for complaints. Throws CameraError. Wants the
/// lock of lock_opening() held.
[[nodiscard]] ObjectPtr<ArvCamera> find_camera(const std::string& uri, const std::string& name);

/// The camera's own network address.
[[nodiscard]] std::string address_of(ArvCamera* camera);

/// Throws what a call reported: CameraError where the connection is at fault, else UsageError.
void check(const CallError& error, const std::string& what);

/// What lies in the pictures of an interlaced camera, by its FieldOutputMode (field 0 is taken for the top one).
enum class Fields : std::uint8_t {
  progressive,
  woven,         ///< DeinterlacedNewFields: both, line by line
  concatenated,  ///< ConcatenatedNewFields: the top field's rows, then the bottom field's
  top,           ///< Field0
  bottom,        ///< Field1
  in_turn,       ///< Field0First: one field after the other, the earlier one first
};

/// Whether a picture is a single field.
[[nodiscard]] constexpr bool is_single(Fields fields) {
  return fields == Fields::top || fields == Fields::bottom || fields == Fields::in_turn;
}

/// What the camera delivers after it was set up.
struct Setup {
  int width = 0;   ///< of the pictures as they arrive
  int height = 0;  ///< likewise: for single fields, of a field
  std::size_t payload = 0;
  GigePixels pixels;
  Fields fields = Fields::progressive;
  FieldOrder order = FieldOrder::progressive;
  double frame_rate = 0.0;  ///< frames per second, 0 where it is not known
  bool software_trigger = false;
  bool hardware_trigger = false;
};

/// Sets the camera. Throws UsageError naming the setting and what is allowed, CameraError.
[[nodiscard]] Setup set_up(ArvCamera* camera, const std::string& uri, const CameraSettings& settings);

/// The strings of an enumeration feature.
[[nodiscard]] std::vector<std::string> entries_of(ArvDevice* device, const char* feature);

/// Sets any feature from text. Throws UsageError, CameraError.
void set_feature(ArvCamera* camera, const std::string& uri, const CameraControl& control);

}  // namespace vsfind::gige
