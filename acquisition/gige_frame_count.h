#pragma once
/// @file
/// A 64-bit count from the frame ids of GigE Vision, which have 16 bits, skip 0 and wrap from 65535 to 1 (or have 64
/// bits with extended ids).

#include <cstdint>
#include <optional>

namespace vsfind {

class GigeFrameCount {
 public:
  /// The number of a whole frame, from 0; a gap is a lost frame. Numbers grow whatever the ids do: an id that stands
  /// still or goes back (the camera started to count anew) counts as the next one.
  std::uint64_t of_whole_frame(std::uint64_t id) {
    if (!last_id_) {
      last_id_ = id;
      return number_ = 0;
    }
    number_ += step_to(id).value_or(1);
    last_id_ = id;
    return number_;
  }

  /// The number of a frame that did not arrive whole: its id may be left over from an earlier use of the buffer. Then
  /// it is taken for the next one. `known` tells whether the id is new, so that what came with it is, too.
  std::uint64_t of_broken_frame(std::uint64_t id, bool& known) {
    const std::optional<std::uint64_t> step = last_id_ ? step_to(id) : std::nullopt;
    constexpr std::uint64_t far = 4096;  // frames; further ahead than any queue, and less than half a turn
    known = step && *step < far;
    if (!last_id_) return number_;  // nothing is known before the first whole frame
    if (known) {
      number_ += *step;
      last_id_ = id;
    } else {
      ++number_;
      last_id_ = next_id(*last_id_);
    }
    return number_;
  }

 private:
  static constexpr std::uint64_t short_ids = 65535;  // 1 … 65535

  [[nodiscard]] static std::uint64_t next_id(std::uint64_t id) { return id == short_ids ? 1 : id + 1; }

  /// Frames from the last id to this one; nothing unless it lies ahead.
  [[nodiscard]] std::optional<std::uint64_t> step_to(std::uint64_t id) const {
    if (id > *last_id_) {
      const std::uint64_t step = id - *last_id_;
      // Of short ids, more than half a turn ahead is a little behind.
      if (id <= short_ids && step > short_ids / 2) return std::nullopt;
      return step;
    }
    if (id == *last_id_ || *last_id_ > short_ids) return std::nullopt;
    const std::uint64_t wrapped = id + short_ids - *last_id_;
    if (wrapped > short_ids / 2) return std::nullopt;
    return wrapped;
  }

  std::optional<std::uint64_t> last_id_;
  std::uint64_t number_ = 0;
};

}  // namespace vsfind
