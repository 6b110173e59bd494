#include "acquisition/v4l2_convert.h"

#include <fmt/format.h>
#include <libv4l-plugin.h>
#include <libv4lconvert.h>

#include <algorithm>
#include <cerrno>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <utility>

namespace vsfind {

struct V4l2Converter::Release {
  void operator()(v4lconvert_data* data) const noexcept { v4lconvert_destroy(data); }
};
struct V4l2Converter::Library {
  std::unique_ptr<v4lconvert_data, Release> data;
};

namespace {

// What libv4l2 asks a device, where there is none.
void* no_init(int /*fd*/) { return nullptr; }
void no_close(void* /*state*/) {}
int no_ioctl(void* /*state*/, int /*fd*/, unsigned long request, void* /*argument*/) {
  if (request == VIDIOC_QUERYCAP) return 0;  // nothing that it could do
  errno = ENOTTY;
  return -1;
}
const libv4l_dev_ops no_device = [] {
  libv4l_dev_ops functions{};
  functions.init = no_init;
  functions.close = no_close;
  functions.ioctl = no_ioctl;
  return functions;
}();

}  // namespace

V4l2Converter::V4l2Converter(int fd, const v4l2_format& format)
    : fd_(fd), source_(format), library_(std::make_unique<Library>()) {
  restart();
  const v4l2_pix_format& from = source_.fmt.pix;
  target_.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  v4l2_pix_format& to = target_.fmt.pix;
  to.width = from.width;
  to.height = from.height;
  to.pixelformat = is_jpeg(from.pixelformat) ? V4L2_PIX_FMT_YUV420 : V4L2_PIX_FMT_RGB24;
  to.field = V4L2_FIELD_NONE;
  v4lconvert_fixup_fmt(&target_);
  const std::size_t pixels = std::size_t{to.width} * to.height;
  picture_.resize(std::max<std::size_t>(to.sizeimage, 3 * pixels));
  grey_.resize(pixels);
  // An empty picture tells whether the format is known at all.
  const std::vector<std::byte> nothing(std::max<std::size_t>(from.sizeimage, 3 * pixels));
  if (luma(nothing).empty() && complaint_.find("Unknown") != std::string::npos)
    throw std::runtime_error(
        fmt::format("pixel format '{}' cannot be converted: {}", fourcc_name(from.pixelformat), complaint_));
}

V4l2Converter::~V4l2Converter() = default;

void V4l2Converter::restart() {
  library_->data.reset(fd_ < 0 ? v4lconvert_create_with_dev_ops(fd_, nullptr, &no_device) : v4lconvert_create(fd_));
  if (!library_->data) throw std::runtime_error("libv4l2 cannot be started");
}

std::span<const std::byte> V4l2Converter::luma(std::span<const std::byte> buffer) {
  const v4l2_pix_format& from = source_.fmt.pix;
  complaint_.clear();
  if (is_jpeg(from.pixelformat) && !jpeg_is_whole(buffer)) {
    complaint_ = "the JPEG picture is cut off";
    return {};
  }
  // After a damaged picture its decoder may be left half-way, and refuse all that follow.
  if (std::exchange(failed_, false)) restart();
  input_.assign(buffer.begin(), buffer.end());
  const int bytes =
      v4lconvert_convert(library_->data.get(), &source_, &target_, reinterpret_cast<unsigned char*>(input_.data()),
                         static_cast<int>(input_.size()), reinterpret_cast<unsigned char*>(picture_.data()),
                         static_cast<int>(picture_.size()));
  if (bytes < 0) {
    failed_ = true;
    complaint_ = v4lconvert_get_error_message(library_->data.get());
    while (!complaint_.empty() && complaint_.back() == '\n') complaint_.pop_back();
    if (complaint_.empty()) complaint_ = "it cannot be converted";
    return {};
  }
  if (target_.fmt.pix.pixelformat == V4L2_PIX_FMT_YUV420) return {picture_.data(), grey_.size()};
  const int width = static_cast<int>(from.width);
  const int height = static_cast<int>(from.height);
  const cv::Mat colour(height, width, CV_8UC3, picture_.data());
  cv::Mat grey(height, width, CV_8UC1, grey_.data());
  cv::cvtColor(colour, grey, cv::COLOR_RGB2GRAY);
  return grey_;
}

}  // namespace vsfind
