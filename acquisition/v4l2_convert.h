#pragma once
/// @file
/// Pixel formats that hold no luma of their own, or hold it compressed, through libv4lconvert (of libv4l2): Motion
/// JPEG, Bayer, RGB and the special formats of many cameras. Inside the V4L2 backend only.

#include <linux/videodev2.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "acquisition/v4l2_format.h"

namespace vsfind {

class V4l2Converter {
 public:
  /// `fd`: the device, of which libv4l2 knows whether its picture stands on its head; -1 for none. `format`: what its
  /// buffers hold. Throws std::runtime_error, with the complaint alone, where libv4l2 cannot convert that.
  V4l2Converter(int fd, const v4l2_format& format);
  ~V4l2Converter();
  V4l2Converter(const V4l2Converter&) = delete;
  V4l2Converter& operator=(const V4l2Converter&) = delete;

  /// The luma of a buffer, 8 bits, width·height bytes without gaps, valid until the next call: of JPEG as it stands
  /// in it, of anything else 0.299 R + 0.587 G + 0.114 B. Empty where the buffer is damaged or cut off; complaint()
  /// then tells why.
  [[nodiscard]] std::span<const std::byte> luma(std::span<const std::byte> buffer);
  [[nodiscard]] const std::string& complaint() const { return complaint_; }

 private:
  struct Release;
  struct Library;
  void restart();

  int fd_;
  v4l2_format source_;
  v4l2_format target_{};
  std::unique_ptr<Library> library_;
  bool failed_ = false;
  std::vector<std::byte> input_;  // the library takes memory that may be written
  std::vector<std::byte> picture_;
  std::vector<std::byte> grey_;
  std::string complaint_;
};

}  // namespace vsfind
