#pragma once
/// @file
/// The driver's buffers, mapped into memory, and the stream through them. Inside the V4L2 backend only.

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "acquisition/frame.h"
#include "acquisition/v4l2_device.h"

namespace vsfind {

/// What a timestamp tells, by the flags of a buffer.
[[nodiscard]] std::pair<Clock, StampedAt> timestamp_kind(std::uint32_t flags);

/// Buffers of a device whose format is set. They are unmapped and given back to the driver in the end, whatever state
/// the device is in by then.
class V4l2Buffers {
 public:
  /// Asks for `wanted` buffers; the driver may give more, or fewer, but two at least. `device` outlives this. Throws
  /// CameraError.
  V4l2Buffers(const V4l2Device& device, int wanted);
  ~V4l2Buffers();
  V4l2Buffers(const V4l2Buffers&) = delete;
  V4l2Buffers& operator=(const V4l2Buffers&) = delete;

  [[nodiscard]] std::size_t count() const { return mapped_.size(); }
  /// Of a buffer before it was used.
  [[nodiscard]] std::uint32_t flags() const { return flags_; }
  /// Queues all buffers and starts.
  void start();

  /// Takes a filled buffer: 0, or errno (EAGAIN: none is there). Of several planes, `filled` is the first one.
  [[nodiscard]] int take(v4l2_buffer& buffer, std::span<const std::byte>& filled) const noexcept;
  /// Queues a buffer again.
  void give(std::uint32_t index) const;

 private:
  void release() noexcept;

  struct Mapping {
    void* data;
    std::size_t size;
  };
  const V4l2Device& device_;
  std::vector<Mapping> mapped_;
  std::uint32_t flags_ = 0;
};

}  // namespace vsfind
