#pragma once
/// @file
/// One picture from a camera or a recording: a lease on the source's buffer, with what is known about it.

#include <cstdint>
#include <memory>
#include <utility>

#include "acquisition/image_view.h"

namespace vsfind {

/// Whoever lends buffers to frames. Lives as long as the last frame that it lent to, so that a buffer can be given
/// back after the source was stopped or destroyed.
class BufferOwner {
 public:
  BufferOwner() = default;
  BufferOwner(const BufferOwner&) = delete;
  BufferOwner& operator=(const BufferOwner&) = delete;
  virtual ~BufferOwner() = default;
  /// Takes buffer `index` back. Called from any thread, once per lease.
  virtual void give_back(std::uint32_t index) noexcept = 0;
};

/// Whether a picture can be searched. Of a frame that is not good, the image may be empty or half written; sequence
/// and timestamp are the source's best knowledge.
enum class FrameStatus : std::uint8_t {
  good,
  incomplete,  ///< a part did not arrive (lost packets, a short buffer)
  corrupt,     ///< the source itself says that the content is wrong
};

/// What the timestamp counts from.
enum class Clock : std::uint8_t {
  none,       ///< no timestamp: 0
  monotonic,  ///< the host's CLOCK_MONOTONIC
  realtime,   ///< the host's CLOCK_REALTIME
  device,     ///< the camera's own counter
  recording,  ///< derived from the recording's frame rate: 0 at its first frame
};

/// Which moment of a frame its timestamp tells.
enum class StampedAt : std::uint8_t {
  unknown,
  start,  ///< when its exposure began
  end,    ///< when its last pixel had come
};

/// In which order the two fields of a frame were exposed.
enum class FieldOrder : std::uint8_t {
  progressive,   ///< both at once: the frame is not interlaced
  top_first,     ///< 625-line systems
  bottom_first,  ///< 525-line systems
  unknown,
};

struct FrameInfo {
  std::uint64_t sequence = 0;     ///< the source's own counter: a gap is a lost frame
  std::int64_t timestamp_ns = 0;  ///< in `clock`
  std::int64_t arrival_ns = 0;    ///< CLOCK_MONOTONIC when the frame came to this process; latency counts from here
  Clock clock = Clock::none;
  StampedAt stamped_at = StampedAt::unknown;
  Field field = Field::frame;  ///< what the picture holds: a whole frame, or a single field of half the rows
  FieldOrder order = FieldOrder::progressive;  ///< of a whole frame
  FrameStatus status = FrameStatus::good;
};

/// A move-only lease on one buffer of a source. Giving it back (destruction) cannot throw.
class Frame {
 public:
  Frame() = default;
  Frame(std::shared_ptr<BufferOwner> owner, std::uint32_t index, const ImageView& image, const FrameInfo& info)
      : info_(info), image_(image), owner_(std::move(owner)), index_(index) {}
  Frame(Frame&& other) noexcept { swap(other); }
  Frame& operator=(Frame&& other) noexcept {
    Frame taken(std::move(other));
    swap(taken);
    return *this;
  }
  Frame(const Frame&) = delete;
  Frame& operator=(const Frame&) = delete;
  ~Frame() {
    if (owner_) owner_->give_back(index_);
  }

  [[nodiscard]] const FrameInfo& info() const { return info_; }
  /// For a source that hands on the frames of another one under a count of its own.
  void set_sequence(std::uint64_t sequence) { info_.sequence = sequence; }
  /// The pixels, valid as long as this frame lives.
  [[nodiscard]] const ImageView& image() const { return image_; }

 private:
  void swap(Frame& other) noexcept {
    std::swap(info_, other.info_);
    std::swap(image_, other.image_);
    std::swap(owner_, other.owner_);
    std::swap(index_, other.index_);
  }

  FrameInfo info_{};
  ImageView image_{};
  std::shared_ptr<BufferOwner> owner_;
  std::uint32_t index_ = 0;
};

}  // namespace vsfind
