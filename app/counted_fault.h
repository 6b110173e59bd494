#pragma once
/// @file
/// A kind of fault that may come with every frame, told of once and then at most once a minute.

#include <chrono>
#include <cstdint>
#include <optional>

namespace vsfind {

class CountedFault {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// Counts `more` of them. Returns how many have come since it was last told, when it is time to tell it.
  std::optional<std::uint64_t> add(std::uint64_t more, Time now = std::chrono::steady_clock::now()) {
    total_ += more;
    untold_ += more;
    constexpr std::chrono::minutes between{1};
    if (untold_ == 0 || (told_ && now - *told_ < between)) return std::nullopt;
    told_ = now;
    const std::uint64_t count = untold_;
    untold_ = 0;
    return count;
  }
  [[nodiscard]] std::uint64_t total() const { return total_; }

 private:
  std::uint64_t total_ = 0;
  std::uint64_t untold_ = 0;
  std::optional<Time> told_;
};

}  // namespace vsfind
