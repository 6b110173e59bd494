#pragma once
/// @file
/// A V4L2 device node that is open: ioctls with errors in plain words. Inside the V4L2 backend only.

#include <linux/videodev2.h>

#include <cstdint>
#include <string>

#include "acquisition/byte_reader.h"
#include "acquisition/errors.h"

namespace vsfind {

/// A device's format as that of one plane: of formats whose planes lie in memories of their own (multi-planar devices),
/// line length and size are those of the first one, which holds the luma.
struct V4l2Format {
  v4l2_pix_format pix{};
  unsigned memories = 1;
};

class V4l2Device {
 public:
  /// Opens a video capture device, of one plane or several, without waiting. Throws CameraError where it is absent, may
  /// not be opened, or is none that captures pictures by streaming.
  explicit V4l2Device(const std::string& path);

  [[nodiscard]] int fd() const { return file_.get(); }
  /// "v4l2:" and the path: every complaint begins with it.
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const v4l2_capability& capability() const { return capability_; }
  /// V4L2_BUF_TYPE_VIDEO_CAPTURE or V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE.
  [[nodiscard]] std::uint32_t stream_type() const { return stream_type_; }
  [[nodiscard]] bool multi_planar() const { return stream_type_ == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE; }

  /// 0, or the errno. Interrupted calls are made again.
  [[nodiscard]] int call(unsigned long request, void* argument) const noexcept;
  /// Throws what failure() gives.
  void require(unsigned long request, void* argument, const char* what) const;
  /// The same of VIDIOC_G_FMT, VIDIOC_TRY_FMT and VIDIOC_S_FMT.
  [[nodiscard]] int call_format(unsigned long request, V4l2Format& format) const noexcept;
  void require_format(unsigned long request, V4l2Format& format, const char* what) const;
  /// "NAME: WHAT: reason": unplugged (ENODEV), held by another program (EBUSY), or what the system says.
  [[nodiscard]] CameraError failure(const std::string& what, int error) const;

 private:
  std::string name_;
  UniqueFd file_;
  v4l2_capability capability_{};
  std::uint32_t stream_type_ = V4L2_BUF_TYPE_VIDEO_CAPTURE;
};

/// Text of one of the kernel's fixed fields, which may lack its final zero.
template <typename Char, std::size_t n>
[[nodiscard]] std::string fixed_text(const Char (&field)[n]) {
  std::string text;
  for (const Char c : field) {
    if (c == 0) break;
    text += static_cast<char>(c);
  }
  return text;
}

}  // namespace vsfind
