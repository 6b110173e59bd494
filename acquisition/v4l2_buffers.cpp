#include "acquisition/v4l2_buffers.h"

#include <fmt/format.h>
#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <cerrno>

namespace vsfind {
namespace {

using Planes = std::array<v4l2_plane, VIDEO_MAX_PLANES>;

v4l2_buffer empty_buffer(const V4l2Device& device, std::uint32_t index, Planes& planes) {
  v4l2_buffer buffer{};
  buffer.type = device.stream_type();
  buffer.memory = V4L2_MEMORY_MMAP;
  buffer.index = index;
  if (device.multi_planar()) {
    buffer.m.planes = planes.data();
    buffer.length = VIDEO_MAX_PLANES;
  }
  return buffer;
}

}  // namespace

std::pair<Clock, StampedAt> timestamp_kind(std::uint32_t flags) {
  if ((flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) != V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC)
    return {Clock::none, StampedAt::unknown};
  const bool at_start = (flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  return {Clock::monotonic, at_start ? StampedAt::start : StampedAt::end};
}

V4l2Buffers::V4l2Buffers(const V4l2Device& device, int wanted) : device_(device) {
  v4l2_requestbuffers request{};
  request.count = static_cast<std::uint32_t>(wanted);
  request.type = device_.stream_type();
  request.memory = V4L2_MEMORY_MMAP;
  device_.require(VIDIOC_REQBUFS, &request, "gives no buffers");
  try {
    if (request.count < 2)
      throw CameraError(fmt::format("{}: gives only {} buffers of {}", device_.name(), request.count, wanted));
    mapped_.reserve(request.count);
    for (std::uint32_t index = 0; index < request.count; ++index) {
      Planes planes{};
      v4l2_buffer buffer = empty_buffer(device_, index, planes);
      device_.require(VIDIOC_QUERYBUF, &buffer, "does not tell where its buffers are");
      flags_ = buffer.flags;
      const std::uint32_t length = device_.multi_planar() ? planes[0].length : buffer.length;
      const std::uint32_t offset = device_.multi_planar() ? planes[0].m.mem_offset : buffer.m.offset;
      void* data = ::mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_SHARED, device_.fd(), offset);
      if (data == MAP_FAILED) throw device_.failure("its buffers cannot be mapped", errno);
      mapped_.push_back({data, length});
    }
  } catch (...) {
    release();
    throw;
  }
}

V4l2Buffers::~V4l2Buffers() {
  std::uint32_t type = device_.stream_type();
  static_cast<void>(device_.call(VIDIOC_STREAMOFF, &type));
  release();
}

void V4l2Buffers::release() noexcept {
  for (const Mapping& mapping : mapped_) ::munmap(mapping.data, mapping.size);
  mapped_.clear();
  v4l2_requestbuffers none{};
  none.type = device_.stream_type();
  none.memory = V4L2_MEMORY_MMAP;
  static_cast<void>(device_.call(VIDIOC_REQBUFS, &none));
}

void V4l2Buffers::start() {
  for (std::uint32_t index = 0; index < mapped_.size(); ++index) give(index);
  std::uint32_t type = device_.stream_type();
  const int error = device_.call(VIDIOC_STREAMON, &type);
  if (error == EPIPE || error == ENOLINK)
    throw CameraError(
        fmt::format("{}: does not start: its sensor does not send the format that it is set to", device_.name()));
  if (error != 0) throw device_.failure("does not start", error);
}

int V4l2Buffers::take(v4l2_buffer& buffer, std::span<const std::byte>& filled) const noexcept {
  Planes planes{};
  buffer = empty_buffer(device_, 0, planes);
  filled = {};
  const int error = device_.call(VIDIOC_DQBUF, &buffer);
  if (error != 0 || buffer.index >= mapped_.size()) return error;
  const Mapping& mapping = mapped_[buffer.index];
  const std::span memory(static_cast<const std::byte*>(mapping.data), mapping.size);
  // Of several planes the bytes used count from the begin of the memory, what lies before the picture with them.
  const std::size_t end =
      std::min<std::size_t>(device_.multi_planar() ? planes[0].bytesused : buffer.bytesused, memory.size());
  const std::size_t begin = device_.multi_planar() ? std::min<std::size_t>(planes[0].data_offset, end) : 0;
  filled = memory.subspan(begin, end - begin);
  buffer.m = {};  // the planes end here
  return 0;
}

void V4l2Buffers::give(std::uint32_t index) const {
  Planes planes{};
  v4l2_buffer buffer = empty_buffer(device_, index, planes);
  device_.require(VIDIOC_QBUF, &buffer, "takes a buffer no more");
}

}  // namespace vsfind
