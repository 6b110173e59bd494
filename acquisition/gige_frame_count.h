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
    advance(last_id_ ? step_to(id).value_or(1) : 1);
    last_id_ = id;
    return *number_;
  }

  /// The number of a frame that did not arrive whole: its id may be left over from an earlier use of the buffer, or 0
  /// where the buffer had none. Then it is taken for the next one. `known` tells whether the id is new, so that what
  /// came with it is, too.
  std::uint64_t of_broken_frame(std::uint64_t id, bool& known) {
    constexpr std::uint64_t far = 4096;  // frames; further ahead than any queue, and less than half a turn
    // Before the first id, no buffer was used before.
    const std::optional<std::uint64_t> step = last_id_      ? step_to(id)
                                              : id != no_id ? std::optional<std::uint64_t>(1)
                                                            : std::nullopt;
    known = step && *step < far;
    advance(known ? *step : 1);
    if (known) {
      last_id_ = id;
    } else if (last_id_) {
      last_id_ = next_id(*last_id_);
    }
    return *number_;
  }

 private:
  static constexpr std::uint64_t short_ids = 65535;  // 1 … 65535
  static constexpr std::uint64_t no_id = 0;          // no frame has it

  void advance(std::uint64_t step) { number_ = number_ ? *number_ + step : 0; }

  [[nodiscard]] static std::uint64_t next_id(std::uint64_t id) { return id == short_ids ? 1 : id + 1; }

  /// Frames from the last id to this one; nothing unless it lies ahead.
  [[nodiscard]] std::optional<std::uint64_t> step_to(std::uint64_t id) const {
    if (id == no_id) return std::nullopt;
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
  std::optional<std::uint64_t> number_;  ///< of the frame before
};

}  // namespace vsfind
