#include "acquisition/v4l2_device.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <sys/stat.h>

#include <cerrno>
#include <system_error>

#include "acquisition/v4l2_fields.h"

namespace vsfind {

static_assert(static_cast<std::uint32_t>(BufferFields::seq_tb) == V4L2_FIELD_SEQ_TB &&
              static_cast<std::uint32_t>(BufferFields::alternate) == V4L2_FIELD_ALTERNATE &&
              static_cast<std::uint32_t>(BufferFields::interlaced_bt) == V4L2_FIELD_INTERLACED_BT);

V4l2Device::V4l2Device(const std::string& path) : name_("v4l2:" + path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) {
    if (errno == ENOENT) throw CameraError(fmt::format("{}: there is no such device", name_));
    throw failure("cannot be opened", errno);
  }
  if (!S_ISCHR(status.st_mode)) throw CameraError(fmt::format("{}: is not a device", name_));
  file_.reset(::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
  if (file_.get() < 0) {
    if (errno == EACCES)
      throw CameraError(fmt::format("{}: may not be opened: this user is not in the device's group (video)", name_));
    throw failure("cannot be opened", errno);
  }
  const int error = call(VIDIOC_QUERYCAP, &capability_);
  if (error == ENOTTY || error == EINVAL) throw CameraError(fmt::format("{}: is not a V4L2 device", name_));
  if (error != 0) throw failure("cannot be asked what it is", error);
  const std::uint32_t can =
      (capability_.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? capability_.device_caps : capability_.capabilities;
  if ((can & (V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_VIDEO_CAPTURE_MPLANE)) == 0)
    throw CameraError(
        fmt::format("{}: captures no pictures (it is for output, metadata or the like); a camera may have several "
                    "nodes: see vsfind cameras",
                    name_));
  if ((can & V4L2_CAP_VIDEO_CAPTURE) == 0) stream_type_ = V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE;
  if ((can & V4L2_CAP_STREAMING) == 0) throw CameraError(fmt::format("{}: cannot stream into memory", name_));
}

int V4l2Device::call(unsigned long request, void* argument) const noexcept {
  for (;;) {
    if (::ioctl(file_.get(), request, argument) >= 0) return 0;
    if (errno != EINTR) return errno;
  }
}

void V4l2Device::require(unsigned long request, void* argument, const char* what) const {
  if (const int error = call(request, argument); error != 0) throw failure(what, error);
}

int V4l2Device::call_format(unsigned long request, V4l2Format& format) const noexcept {
  v4l2_format whole{};
  whole.type = stream_type_;
  v4l2_pix_format& pix = format.pix;
  if (!multi_planar()) {
    whole.fmt.pix = pix;
    const int error = call(request, &whole);
    if (error == 0) pix = whole.fmt.pix;
    return error;
  }
  v4l2_pix_format_mplane& planes = whole.fmt.pix_mp;
  planes.width = pix.width;
  planes.height = pix.height;
  planes.pixelformat = pix.pixelformat;
  planes.field = pix.field;
  planes.colorspace = pix.colorspace;
  planes.num_planes = static_cast<std::uint8_t>(format.memories);
  planes.plane_fmt[0].bytesperline = pix.bytesperline;
  planes.plane_fmt[0].sizeimage = pix.sizeimage;
  const int error = call(request, &whole);
  if (error != 0) return error;
  pix = {};
  pix.width = planes.width;
  pix.height = planes.height;
  pix.pixelformat = planes.pixelformat;
  pix.field = planes.field;
  pix.colorspace = planes.colorspace;
  pix.bytesperline = planes.plane_fmt[0].bytesperline;
  pix.sizeimage = planes.plane_fmt[0].sizeimage;
  format.memories = planes.num_planes;
  return 0;
}

void V4l2Device::require_format(unsigned long request, V4l2Format& format, const char* what) const {
  if (const int error = call_format(request, format); error != 0) throw failure(what, error);
}

CameraError V4l2Device::failure(const std::string& what, int error) const {
  switch (error) {
    case ENODEV:
    case ENXIO:
      return CameraError(fmt::format("{}: {}: it was unplugged", name_, what));
    case EBUSY:
      return CameraError(fmt::format("{}: {}: it is held by another program", name_, what));
    default:
      return CameraError(fmt::format("{}: {}: {}", name_, what, std::generic_category().message(error)));
  }
}

}  // namespace vsfind
