#include "acquisition/v4l2_buffers.h"

#include <fmt/format.h>
#include <sys/mman.h>

#include <cerrno>

namespace vsfind {
namespace {

constexpr std::uint32_t stream_type = V4L2_BUF_TYPE_VIDEO_CAPTURE;

v4l2_buffer empty_buffer(std::uint32_t index) {
  v4l2_buffer buffer{};
  buffer.type = stream_type;
  buffer.memory = V4L2_MEMORY_MMAP;
  buffer.index = index;
  return buffer;
}

}  // namespace

V4l2Buffers::V4l2Buffers(const V4l2Device& device, int wanted) : device_(device) {
  v4l2_requestbuffers request{};
  request.count = static_cast<std::uint32_t>(wanted);
  request.type = stream_type;
  request.memory = V4L2_MEMORY_MMAP;
  device_.require(VIDIOC_REQBUFS, &request, "gives no buffers");
  try {
    if (request.count < 2)
      throw CameraError(fmt::format("{}: gives only {} buffers of {}", device_.name(), request.count, wanted));
    mapped_.reserve(request.count);
    for (std::uint32_t index = 0; index < request.count; ++index) {
      v4l2_buffer buffer = empty_buffer(index);
      device_.require(VIDIOC_QUERYBUF, &buffer, "does not tell where its buffers are");
      void* data = ::mmap(nullptr, buffer.length, PROT_READ | PROT_WRITE, MAP_SHARED, device_.fd(), buffer.m.offset);
      if (data == MAP_FAILED) throw device_.failure("its buffers cannot be mapped", errno);
      mapped_.push_back({data, buffer.length});
    }
  } catch (...) {
    release();
    throw;
  }
}

V4l2Buffers::~V4l2Buffers() {
  std::uint32_t type = stream_type;
  static_cast<void>(device_.call(VIDIOC_STREAMOFF, &type));
  release();
}

void V4l2Buffers::release() noexcept {
  for (const Mapping& mapping : mapped_) ::munmap(mapping.data, mapping.size);
  mapped_.clear();
  v4l2_requestbuffers none{};
  none.type = stream_type;
  none.memory = V4L2_MEMORY_MMAP;
  static_cast<void>(device_.call(VIDIOC_REQBUFS, &none));
}

void V4l2Buffers::start() {
  for (std::uint32_t index = 0; index < mapped_.size(); ++index) give(index);
  std::uint32_t type = stream_type;
  const int error = device_.call(VIDIOC_STREAMON, &type);
  if (error == EPIPE || error == ENOLINK)
    throw CameraError(
        fmt::format("{}: does not start: its sensor does not send the format that it is set to", device_.name()));
  if (error != 0) throw device_.failure("does not start", error);
}

int V4l2Buffers::take(v4l2_buffer& buffer) const noexcept {
  buffer = empty_buffer(0);
  return device_.call(VIDIOC_DQBUF, &buffer);
}

void V4l2Buffers::give(std::uint32_t index) const {
  v4l2_buffer buffer = empty_buffer(index);
  device_.require(VIDIOC_QBUF, &buffer, "takes a buffer no more");
}

std::span<const std::byte> V4l2Buffers::memory(std::uint32_t index) const {
  if (index >= mapped_.size()) return {};
  return {static_cast<const std::byte*>(mapped_[index].data), mapped_[index].size};
}

}  // namespace vsfind
