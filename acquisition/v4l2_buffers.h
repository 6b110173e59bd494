#pragma once
/// @file
/// The driver's buffers, mapped into memory, and the stream through them. Inside the V4L2 backend only.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "acquisition/v4l2_device.h"

namespace vsfind {

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
  /// Queues all buffers and starts.
  void start();

  /// Takes a filled buffer: 0, or errno (EAGAIN: none is there).
  [[nodiscard]] int take(v4l2_buffer& buffer) const noexcept;
  /// Queues a buffer again.
  void give(std::uint32_t index) const;
  /// The memory of a buffer; empty where the driver names none of ours.
  [[nodiscard]] std::span<const std::byte> memory(std::uint32_t index) const;

 private:
  void release() noexcept;

  struct Mapping {
    void* data;
    std::size_t size;
  };
  const V4l2Device& device_;
  std::vector<Mapping> mapped_;
};

}  // namespace vsfind
