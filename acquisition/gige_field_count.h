#pragma once
/// @file
/// Which field of which frame a picture is, where a GigE camera sends its fields in turn (FieldOutputMode Field0First):
/// the picture itself does not tell, its id does. Fields are counted from the start of the acquisition, which begins
/// with field 0, so a lost one does not swap those that follow.

#include <cstdint>
#include <optional>

namespace vsfind {

class GigeFieldCount {
 public:
  /// Where a picture belongs.
  struct Place {
    std::uint64_t frame = 0;  ///< both fields of a frame have its number
    bool second = false;      ///< field 1
  };

  Place of_whole_field(std::uint64_t id) {
    if (!last_id_) {
      // The standard's first id is 1. A camera that begins elsewhere is taken at its first picture, and what came
      // broken before that.
      constexpr std::uint64_t near_the_begin = 1024;
      position_ = id >= 1 && id <= near_the_begin ? id - 1 : broken_before_;
    } else {
      position_ += distance(*last_id_, id);
    }
    last_id_ = id;
    shown_ = position_;
    return place(position_);
  }

  /// Of a field that did not arrive whole: its id may be left over from an earlier use of the buffer; then it is taken
  /// for the next one, and those after it are counted as if it had not come.
  Place of_broken_field(std::uint64_t id, bool& known) {
    constexpr std::uint64_t far = 4096;  // further ahead than any queue
    // Before the first id no buffer was used before; one that shows none has 0.
    const std::uint64_t step = id == 0 ? 0 : last_id_ ? distance(*last_id_, id) : 1;
    known = step > 0 && step < far;
    if (known) return of_whole_field(id);
    if (!last_id_) return place(broken_before_++);
    return place(++shown_);
  }

 private:
  static constexpr std::uint64_t short_ids = 65535;  // 1 … 65535, then 1 again

  [[nodiscard]] static Place place(std::uint64_t position) { return {position / 2, position % 2 == 1}; }

  /// From one id to a later one; 0 for one that does not lie ahead.
  [[nodiscard]] static std::uint64_t distance(std::uint64_t from, std::uint64_t to) {
    if (to >= from) return to - from;
    return from <= short_ids ? to + short_ids - from : 0;
  }

  std::optional<std::uint64_t> last_id_;
  std::uint64_t position_ = 0;  // of last_id_, in fields
  std::uint64_t shown_ = 0;     // of the last place given
  std::uint64_t broken_before_ = 0;
};

}  // namespace vsfind
