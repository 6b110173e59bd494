#include "tests/acquisition/vivid/vivid_device.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <vector>

#include "acquisition/byte_reader.h"

namespace vsfind::test {
namespace {

class Node {
 public:
  explicit Node(const std::string& path, int flags = 0)
      : path_(path), file_(::open(path.c_str(), O_RDWR | O_CLOEXEC | flags)) {
    if (file_.get() < 0) throw std::runtime_error(fmt::format("{}: {}", path, std::strerror(errno)));
  }
  [[nodiscard]] bool call(unsigned long request, void* argument) const {
    while (::ioctl(file_.get(), request, argument) != 0) {
      if (errno != EINTR) return false;
    }
    return true;
  }
  void require(unsigned long request, void* argument, const char* what) const {
    if (!call(request, argument))
      throw std::runtime_error(fmt::format("{}: {}: {}", path_, what, std::strerror(errno)));
  }
  [[nodiscard]] int fd() const { return file_.get(); }

 private:
  std::string path_;
  UniqueFd file_;
};

constexpr std::uint32_t output = V4L2_BUF_TYPE_VIDEO_OUTPUT;

v4l2_dv_timings timings_640x480(const Node& node) {
  v4l2_enum_dv_timings known{};
  for (known.index = 0; node.call(VIDIOC_ENUM_DV_TIMINGS, &known); ++known.index) {
    const v4l2_bt_timings& bt = known.timings.bt;
    if (bt.width == 640 && bt.height == 480 && bt.interlaced == 0) return known.timings;
  }
  throw std::runtime_error("no timings of 640x480");
}

}  // namespace

void set_vivid(const std::string& device, const std::string& control, std::int64_t value) {
  const Node node(device);
  constexpr std::uint32_t next = V4L2_CTRL_FLAG_NEXT_CTRL;
  v4l2_query_ext_ctrl known{};
  for (known.id = next; node.call(VIDIOC_QUERY_EXT_CTRL, &known); known.id |= next) {
    if (control != known.name) continue;
    v4l2_control set{known.id, static_cast<std::int32_t>(value)};
    node.require(VIDIOC_S_CTRL, &set, control.c_str());
    return;
  }
  throw std::runtime_error(fmt::format("{}: no control '{}'", device, control));
}

void select_vivid(const std::string& device, std::uint32_t input, bool analogue, bool lines_525) {
  const Node node(device);
  node.require(VIDIOC_S_INPUT, &input, "input");
  v4l2_std_id standard = lines_525 ? V4L2_STD_NTSC : V4L2_STD_PAL;
  if (analogue) node.require(VIDIOC_S_STD, &standard, "standard");
}

void shrink_picture(const std::string& device) {
  const Node node(device);
  v4l2_selection compose{};
  compose.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  compose.target = V4L2_SEL_TGT_COMPOSE;
  node.require(VIDIOC_G_SELECTION, &compose, "compose");
  compose.r = {0, 0, compose.r.width / 2, compose.r.height / 2};
  node.require(VIDIOC_S_SELECTION, &compose, "compose");
}

void set_vivid_timings(const std::string& device) {
  const Node node(device);
  v4l2_dv_timings timings = timings_640x480(node);
  node.require(VIDIOC_S_DV_TIMINGS, &timings, "timings");
}

void show(const std::string& device, Signal signal, const ShownFrames& frames, std::uint32_t field, bool yuyv,
          void (*ready)()) {
  const Node node(device, O_NONBLOCK);
  std::uint32_t connector = signal == Signal::hdmi ? 1 : 0;
  node.require(VIDIOC_S_OUTPUT, &connector, "output");
  v4l2_std_id standard = signal == Signal::ntsc ? V4L2_STD_NTSC : V4L2_STD_PAL;
  if (signal != Signal::hdmi) node.require(VIDIOC_S_STD, &standard, "standard");
  if (signal == Signal::hdmi) set_vivid_timings(device);

  const bool alternate = field == V4L2_FIELD_ALTERNATE;
  const auto rows = static_cast<std::uint32_t>(alternate ? frames.height() / 2 : frames.height());
  v4l2_format format{};
  format.type = output;
  node.require(VIDIOC_G_FMT, &format, "format");
  v4l2_pix_format& pix = format.fmt.pix;
  pix.width = static_cast<std::uint32_t>(frames.width());
  pix.height = rows;
  pix.pixelformat = yuyv ? V4L2_PIX_FMT_YUYV : V4L2_PIX_FMT_GREY;
  pix.field = field;
  pix.bytesperline = 0;
  node.require(VIDIOC_S_FMT, &format, "format");
  if (pix.width != static_cast<std::uint32_t>(frames.width()) || pix.height != rows || pix.field != field)
    throw std::runtime_error(fmt::format("{}: gives {}x{} field {}", device, pix.width, pix.height, pix.field));
  v4l2_selection crop{};
  crop.type = output;
  crop.target = V4L2_SEL_TGT_CROP;
  crop.r = {0, 0, pix.width, pix.height};
  node.require(VIDIOC_S_SELECTION, &crop, "crop");

  v4l2_requestbuffers request{};
  request.count = 4;
  request.type = output;
  request.memory = V4L2_MEMORY_MMAP;
  node.require(VIDIOC_REQBUFS, &request, "buffers");
  std::vector<std::uint8_t*> memory;
  for (std::uint32_t index = 0; index < request.count; ++index) {
    v4l2_buffer buffer{};
    buffer.type = output;
    buffer.memory = V4L2_MEMORY_MMAP;
    buffer.index = index;
    node.require(VIDIOC_QUERYBUF, &buffer, "buffer");
    void* data = ::mmap(nullptr, buffer.length, PROT_READ | PROT_WRITE, MAP_SHARED, node.fd(), buffer.m.offset);
    if (data == MAP_FAILED) throw std::runtime_error("a buffer cannot be mapped");
    memory.push_back(static_cast<std::uint8_t*>(data));
  }

  std::vector<std::uint8_t> picture;
  std::uint32_t shown = 0;  // buffers
  const bool top_first = signal != Signal::ntsc;
  const auto queue = [&](std::uint32_t index) {
    const bool first = !alternate || shown % 2 == 0;
    if (first) frames.draw(alternate ? shown / 2 : shown, picture);
    const bool top = first == top_first;
    const auto width = static_cast<std::size_t>(frames.width());
    for (std::uint32_t row = 0; row < rows; ++row) {
      const std::size_t line = alternate ? 2 * std::size_t{row} + (top ? 0 : 1) : row;
      const std::uint8_t* from = picture.data() + line * width;
      std::uint8_t* to = memory[index] + std::size_t{row} * pix.bytesperline;
      if (!yuyv) {
        std::memcpy(to, from, width);
        continue;
      }
      for (std::size_t x = 0; x < width; ++x) {
        to[2 * x] = from[x];
        to[2 * x + 1] = static_cast<std::uint8_t>(x * 7);  // no chroma that could pass for luma
      }
    }
    v4l2_buffer buffer{};
    buffer.type = output;
    buffer.memory = V4L2_MEMORY_MMAP;
    buffer.index = index;
    buffer.bytesused = pix.sizeimage;
    buffer.field = field;
    if (alternate) buffer.field = top ? V4L2_FIELD_TOP : V4L2_FIELD_BOTTOM;
    node.require(VIDIOC_QBUF, &buffer, "queue");
    ++shown;
  };
  for (std::uint32_t index = 0; index < request.count; ++index) queue(index);
  std::uint32_t type = output;
  node.require(VIDIOC_STREAMON, &type, "start");
  for (;;) {
    pollfd waited{node.fd(), POLLOUT, 0};
    ::poll(&waited, 1, 2000);
    v4l2_buffer buffer{};
    buffer.type = output;
    buffer.memory = V4L2_MEMORY_MMAP;
    if (!node.call(VIDIOC_DQBUF, &buffer)) {
      if (errno == EAGAIN) continue;
      throw std::runtime_error(fmt::format("{}: shows no more: {}", device, std::strerror(errno)));
    }
    queue(buffer.index);
    constexpr std::uint32_t settled = 8;
    if (shown == settled) ready();
  }
}

}  // namespace vsfind::test
