#include "acquisition/buffer_pool.h"

#include <algorithm>
#include <new>

namespace vsfind {
namespace {

constexpr std::align_val_t alignment{64};

}  // namespace

void BufferPool::Free::operator()(std::byte* data) const noexcept { ::operator delete(data, alignment); }

BufferPool::BufferPool(std::uint32_t limit) {
  buffers_.reserve(std::max(limit, 1U));
  free_.reserve(buffers_.capacity());
}

std::shared_ptr<BufferPool> BufferPool::create(std::uint32_t limit) {
  return std::shared_ptr<BufferPool>(new BufferPool(limit));
}

std::optional<BufferPool::Lease> BufferPool::acquire(std::size_t bytes) {
  std::unique_lock lock(mutex_);
  given_back_.wait(lock, [this] { return stopped_ || !free_.empty() || buffers_.size() < buffers_.capacity(); });
  if (stopped_) return std::nullopt;
  if (free_.empty()) {
    free_.push_back(static_cast<std::uint32_t>(buffers_.size()));
    buffers_.emplace_back();
  }
  const std::uint32_t index = free_.back();
  Buffer& buffer = buffers_[index];
  if (buffer.size < bytes || !buffer.data) {
    buffer.data.reset();
    buffer.size = 0;
    buffer.data.reset(static_cast<std::byte*>(::operator new(std::max<std::size_t>(bytes, 1), alignment)));
    buffer.size = bytes;
  }
  free_.pop_back();
  return Lease(shared_from_this(), index, buffer.data.get());
}

void BufferPool::stop() noexcept {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
  }
  given_back_.notify_all();
}

void BufferPool::give_back(std::uint32_t index) noexcept {
  {
    const std::lock_guard lock(mutex_);
    free_.push_back(index);
  }
  given_back_.notify_one();
}

std::uint32_t recording_buffers(std::size_t frame_bytes) {
  constexpr std::size_t budget = std::size_t{256} << 20U;
  return static_cast<std::uint32_t>(std::clamp<std::size_t>(budget / std::max<std::size_t>(frame_bytes, 1), 8, 1024));
}

}  // namespace vsfind
