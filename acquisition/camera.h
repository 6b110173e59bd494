#pragma once
/// @file
/// Cameras: what they are asked for, how they are opened by a URI, and what can be opened.
///
///     v4l2:/dev/videoN      a V4L2 device
///     gige:NAME-OR-ADDRESS  a GigE Vision camera by its name, serial number, or network address; `gige:` the first one
///     file:SEQUENCE         a recording or a folder of images, as open_sequence (source.h)

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/source.h"

namespace vsfind {

/// A control or feature by the name that the camera gives it, and its value as text.
struct CameraControl {
  std::string name;
  std::string value;
};

/// What a camera is set to when it is opened. What is not given (0, empty, nothing) is left as the camera has it, but
/// for what the text says. Each backend refuses with UsageError what its camera does not have or cannot do, naming what
/// it can; it ignores what only the other kind of camera knows.
struct CameraSettings {
  int width = 0;                      ///< pixels
  int height = 0;                     ///< rows of a whole frame
  std::optional<int> offset_x;        ///< left column of the region read out, sensor pixels
  std::optional<int> offset_y;        ///< its top row
  std::string pixel_format;           ///< as the camera calls it: "Mono8", "GREY", "YUYV"; empty: the best for luma
  double frame_rate = 0.0;            ///< frames per second
  std::optional<double> exposure_us;  ///< microseconds; switches automatic exposure off
  std::optional<double> gain;         ///< in the camera's unit; switches automatic gain off
  std::string trigger;                ///< "off" (also when empty), "software", or a hardware line: "Line1"
  double trigger_rate = 0.0;  ///< software triggers per second that the source fires itself; 0: as fast as frames come
  std::string field_order;    ///< V4L2: as its field orders are called ("interlaced", "alternate", …); GigE:
                              ///< "interlaced-tb", "interlaced-bt": whether the top or the bottom field is the earlier
  std::string input;          ///< V4L2: name or number of the input
  std::string standard;       ///< V4L2: "PAL", "NTSC", …
  std::vector<CameraControl> controls;  ///< set in this order, after all of the above
  int buffers = 8;                      ///< that wait for frames, 4 to 64
  double frame_timeout_s = 2.0;         ///< no frame for so long is a fault; 0, or any hardware trigger: wait for ever
  int packet_size = 0;                  ///< GigE: bytes; 0: the largest that the path carries
  int socket_buffer = 0;                ///< GigE: bytes of the receive buffer; 0: chosen to hold frames
  std::optional<bool> packet_socket;  ///< GigE: receive past the kernel's UDP; nothing: where it is permitted and works
  bool packet_resend = true;          ///< GigE: ask for lost packets again
};

/// Opens what the URI names. Throws UsageError where the URI or a setting is wrong, CameraError where the camera is
/// absent, held by another program, or of a kind that this program was built without, IoError for a recording. It is
/// not reopened when it is lost: see reconnecting_source.h.
[[nodiscard]] std::unique_ptr<FrameSource> open_source(const std::string& uri, const CameraSettings& settings);

/// A URI's two parts, checked: a known scheme, and a name where one is needed. Throws UsageError.
struct SourceUri {
  enum class Scheme : std::uint8_t { v4l2, gige, file };
  Scheme scheme = Scheme::file;
  std::string name;  ///< after the colon
};
[[nodiscard]] SourceUri parse_source_uri(const std::string& uri);

/// Throws CameraError where this program was built without what the URI's kind of camera needs, saying which Debian
/// package that is. Throws UsageError as parse_source_uri().
void require_backend(const std::string& uri);

/// From here on what the libraries of the cameras have to say by themselves goes to the log (spdlog, level info, what
/// ends the process: error), a line each, instead of straight to stderr. Of the whole process: a program calls it,
/// once.
void log_camera_libraries();

/// Frame sizes that a camera offers in one pixel format; of a fixed size both ends are the same.
struct CameraSizes {
  int min_width = 0;
  int min_height = 0;
  int max_width = 0;
  int max_height = 0;
  int step_x = 0;  ///< 0 for a fixed size
  int step_y = 0;
  std::vector<double> rates;  ///< frames per second, where the camera lists them; a range as its two ends
  bool rates_are_range = false;
};
struct CameraFormat {
  std::string name;         ///< as CameraSettings::pixel_format takes it
  std::string description;  ///< what the camera says of it
  bool direct = false;      ///< luma is read without a conversion
  std::vector<CameraSizes> sizes;
};

/// A camera that can be opened.
struct CameraDescription {
  std::string uri;
  std::string vendor;
  std::string model;
  std::string serial;
  std::string address;                ///< network address or bus
  std::vector<CameraFormat> formats;  ///< none where they cannot be asked for
  Clock clock = Clock::none;          ///< of the frames' timestamps, where that can be asked for
  StampedAt stamped_at = StampedAt::unknown;
  std::string problem;  ///< why it cannot be opened now ("held by another program"), else empty
};

/// All cameras that this program was built for and that can be seen now: V4L2 devices, then GigE cameras. Takes about a
/// second for the network.
[[nodiscard]] std::vector<CameraDescription> list_cameras();

}  // namespace vsfind
