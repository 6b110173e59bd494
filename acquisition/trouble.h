#pragma once
/// @file
/// Something that goes wrong again and again, told of once: when it begins, and when it has not happened for a while.

#include <cstdint>

namespace vsfind {

class Trouble {
 public:
  enum class Change : std::uint8_t { none, begun, ended };
  /// So many frames in a row without it end it.
  static constexpr int quiet_frames = 1000;

  /// Tells it of every frame what it cost: 0 where it did not happen. A single occurrence begins and ends like a long
  /// series.
  Change update(std::uint64_t cost) {
    if (cost > 0) {
      const bool begins = !active_;
      count_ = begins ? cost : count_ + cost;
      active_ = true;
      quiet_ = 0;
      return begins ? Change::begun : Change::none;
    }
    if (!active_ || ++quiet_ < quiet_frames) return Change::none;
    active_ = false;
    return Change::ended;
  }
  /// What it cost since it began.
  [[nodiscard]] std::uint64_t count() const { return count_; }

 private:
  bool active_ = false;
  int quiet_ = 0;
  std::uint64_t count_ = 0;
};

}  // namespace vsfind
