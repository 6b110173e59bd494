#pragma once
/// @file
/// Reusable buffers for sources that read into memory of their own.

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "acquisition/frame.h"

namespace vsfind {

/// A bounded number of buffers, each allocated when it is first needed and used again and again. Frames keep the pool
/// alive, so the source may go before them. Thread-safe.
class BufferPool final : public BufferOwner, public std::enable_shared_from_this<BufferPool> {
 public:
  /// One lent buffer. It becomes a Frame, or goes back by itself where filling it failed.
  class Lease {
   public:
    Lease(Lease&& other) noexcept : pool_(std::move(other.pool_)), index_(other.index_), data_(other.data_) {}
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    Lease& operator=(Lease&&) = delete;
    ~Lease() {
      if (pool_) pool_->give_back(index_);
    }
    /// First byte, aligned to 64; contents undefined.
    [[nodiscard]] std::byte* data() const { return data_; }
    /// Hands the buffer over to a frame. `image` lies in this buffer.
    [[nodiscard]] Frame to_frame(const ImageView& image, const FrameInfo& info) && {
      return {std::move(pool_), index_, image, info};
    }

   private:
    friend class BufferPool;
    Lease(std::shared_ptr<BufferPool> pool, std::uint32_t index, std::byte* data)
        : pool_(std::move(pool)), index_(index), data_(data) {}

    std::shared_ptr<BufferPool> pool_;
    std::uint32_t index_;
    std::byte* data_;
  };

  /// A pool of at most `limit` buffers (at least one).
  [[nodiscard]] static std::shared_ptr<BufferPool> create(std::uint32_t limit);

  /// A free buffer of at least `bytes`, the last one given back first. While all are lent it waits for one; nothing
  /// after stop(). Throws std::bad_alloc, with the pool as it was.
  [[nodiscard]] std::optional<Lease> acquire(std::size_t bytes);

  /// Makes a waiting and every later acquire() return nothing.
  void stop() noexcept;

  void give_back(std::uint32_t index) noexcept override;

 private:
  struct Free {
    void operator()(std::byte* data) const noexcept;
  };
  struct Buffer {
    std::unique_ptr<std::byte, Free> data;
    std::size_t size = 0;
  };

  explicit BufferPool(std::uint32_t limit);

  std::mutex mutex_;
  std::condition_variable given_back_;
  std::vector<Buffer> buffers_;      // never moves: its capacity is the limit
  std::vector<std::uint32_t> free_;  // likewise, so that giving back allocates nothing
  bool stopped_ = false;
};

/// How many frames of a recording may be held at once: what fits into 256 MiB, but 8 to 1024. A caller who holds them
/// all waits in next() until one is given back.
[[nodiscard]] std::uint32_t recording_buffers(std::size_t frame_bytes);

}  // namespace vsfind
