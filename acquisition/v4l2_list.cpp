#include <fcntl.h>
#include <linux/media.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <tuple>

#include "acquisition/v4l2_buffers.h"
#include "acquisition/v4l2_device.h"
#include "acquisition/v4l2_fields.h"
#include "acquisition/v4l2_input.h"
#include "acquisition/v4l2_picture.h"
#include "acquisition/v4l2_source.h"

namespace vsfind {
namespace {

namespace fs = std::filesystem;

std::string first_line(const fs::path& file) {
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  return line;
}

/// What the device's place in sysfs knows: of USB cameras maker and serial number.
void describe_usb(const fs::path& node, CameraDescription& camera) {
  std::error_code error;
  const fs::path interface = fs::canonical(fs::path("/sys/class/video4linux") / node.filename() / "device", error);
  if (error) return;
  const fs::path device = interface.parent_path();
  if (!fs::exists(device / "idVendor", error)) return;
  camera.serial = first_line(device / "serial");
  camera.vendor = first_line(device / "manufacturer");
}

/// The serial number as the media controller tells it, for all other devices.
void describe_media(const fs::path& node, CameraDescription& camera) {
  std::error_code error;
  const fs::path place = fs::path("/sys/class/video4linux") / node.filename() / "device";
  for (fs::directory_iterator entry(place, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (!name.starts_with("media")) continue;
    const UniqueFd media(::open(("/dev/" + name).c_str(), O_RDWR | O_CLOEXEC));
    media_device_info info{};
    if (media.get() < 0 || ::ioctl(media.get(), MEDIA_IOC_DEVICE_INFO, &info) != 0) continue;
    if (camera.serial.empty()) camera.serial = fixed_text(info.serial);
    if (camera.model.empty()) camera.model = fixed_text(info.model);
  }
}

CameraSizes sizes_of(const V4l2Device& device, std::uint32_t fourcc, std::uint32_t min_width, std::uint32_t min_height,
                     std::uint32_t max_width, std::uint32_t max_height, std::uint32_t step_x, std::uint32_t step_y) {
  CameraSizes sizes;
  sizes.min_width = static_cast<int>(min_width);
  sizes.min_height = static_cast<int>(min_height);
  sizes.max_width = static_cast<int>(max_width);
  sizes.max_height = static_cast<int>(max_height);
  sizes.step_x = static_cast<int>(step_x);
  sizes.step_y = static_cast<int>(step_y);
  sizes.rates = frame_rates(device, fourcc, max_width, max_height, sizes.rates_are_range);
  return sizes;
}

/// Of inputs that list no sizes (analogue ones): the one that the driver gives when it is asked for its picture.
CameraSizes present_size(const V4l2Device& device, std::uint32_t fourcc) {
  V4l2Format format;
  if (device.call_format(VIDIOC_G_FMT, format) != 0) return {};
  const v4l2_pix_format& pix = format.pix;
  format.pix.pixelformat = fourcc;
  if (device.call_format(VIDIOC_TRY_FMT, format) != 0) return {};
  const auto rows =
      static_cast<std::uint32_t>(frame_rows(static_cast<BufferFields>(pix.field), static_cast<int>(pix.height)));
  CameraSizes sizes = sizes_of(device, fourcc, pix.width, rows, pix.width, rows, 0, 0);
  v4l2_streamparm parameters{};
  parameters.type = device.stream_type();
  if (sizes.rates.empty() && device.call(VIDIOC_G_PARM, &parameters) == 0) {
    const v4l2_fract period = parameters.parm.capture.timeperframe;
    if (period.numerator > 0 && period.denominator > 0)
      sizes.rates.push_back(static_cast<double>(period.denominator) / period.numerator);
  }
  return sizes;
}

CameraFormat format_of(const V4l2Device& device, const v4l2_fmtdesc& description) {
  CameraFormat format;
  const std::uint32_t fourcc = description.pixelformat;
  format.name = fourcc_name(fourcc);
  format.description = fixed_text(description.description);
  format.direct = luma_layout(fourcc).has_value();
  v4l2_frmsizeenum size{};
  size.pixel_format = fourcc;
  while (device.call(VIDIOC_ENUM_FRAMESIZES, &size) == 0) {
    if (size.type == V4L2_FRMSIZE_TYPE_DISCRETE) {
      format.sizes.push_back(sizes_of(device, fourcc, size.discrete.width, size.discrete.height, size.discrete.width,
                                      size.discrete.height, 0, 0));
    } else {
      const v4l2_frmsize_stepwise& range = size.stepwise;
      format.sizes.push_back(sizes_of(device, fourcc, range.min_width, range.min_height, range.max_width,
                                      range.max_height, range.step_width, range.step_height));
      break;
    }
    const std::uint32_t index = size.index + 1;
    size = {};
    size.index = index;
    size.pixel_format = fourcc;
  }
  if (format.sizes.empty()) {
    const CameraSizes present = present_size(device, fourcc);
    if (present.max_width > 0) format.sizes.push_back(present);
  }
  return format;
}

/// Whether another program streams. Asking for no buffers does nothing where none does.
bool is_held(const V4l2Device& device) {
  v4l2_requestbuffers none{};
  none.type = device.stream_type();
  none.memory = V4L2_MEMORY_MMAP;
  return device.call(VIDIOC_REQBUFS, &none) == EBUSY;
}

/// What timestamps tell stands in the buffers alone: some are asked for, and given back.
void describe_timestamps(const V4l2Device& device, CameraDescription& camera) {
  try {
    const V4l2Buffers buffers(device, 2);
    std::tie(camera.clock, camera.stamped_at) = timestamp_kind(buffers.flags());
  } catch (const CameraError&) {  // none to be had now: not told
  }
}

/// The video nodes, by their numbers.
std::vector<fs::path> video_nodes() {
  std::vector<std::pair<int, fs::path>> nodes;
  std::error_code error;
  for (fs::directory_iterator entry("/dev", error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    constexpr std::string_view prefix = "video";
    if (!name.starts_with(prefix) || name.size() == prefix.size() || name.size() > prefix.size() + 6) continue;
    const std::string digits = name.substr(prefix.size());
    if (std::all_of(digits.begin(), digits.end(), [](char c) { return c >= '0' && c <= '9'; }))
      nodes.emplace_back(std::stoi(digits), entry->path());
  }
  std::sort(nodes.begin(), nodes.end());
  std::vector<fs::path> paths;
  paths.reserve(nodes.size());
  for (auto& node : nodes) paths.push_back(std::move(node.second));
  return paths;
}

}  // namespace

std::vector<CameraDescription> list_v4l2() {
  std::vector<CameraDescription> cameras;
  for (const fs::path& node : video_nodes()) {
    CameraDescription camera;
    camera.uri = "v4l2:" + node.string();
    // It may be no camera at all, but the user wants to know why a camera is not listed.
    if (::access(node.c_str(), R_OK | W_OK) != 0 && errno == EACCES) {
      camera.problem = "may not be opened: this user is not in the device's group (video)";
      cameras.push_back(std::move(camera));
      continue;
    }
    try {
      const V4l2Device device(node.string());
      camera.model = fixed_text(device.capability().card);
      camera.address = fixed_text(device.capability().bus_info);
      describe_usb(node, camera);
      describe_media(node, camera);
      for (const v4l2_fmtdesc& format : pixel_formats(device)) camera.formats.push_back(format_of(device, format));
      const bool held = is_held(device);
      camera.problem = held ? "held by another program" : signal_problem(device);
      if (!held) describe_timestamps(device, camera);
    } catch (const CameraError&) {
      continue;  // nodes for output, metadata and the like are no cameras
    }
    cameras.push_back(std::move(camera));
  }
  return cameras;
}

}  // namespace vsfind
