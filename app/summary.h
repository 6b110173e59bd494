#pragma once
/// @file
/// The closing summary: counts and search times, in bounded memory however long the run.

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "app/frame_searcher.h"

namespace vsfind {

/// Times in logarithmic classes, 1% wide: quantiles are right to half a per cent, the maximum exactly.
class TimeHistogram {
 public:
  void add(double ms);
  [[nodiscard]] std::uint64_t count() const { return count_; }
  /// The time that the part `q` (0 … 1) of all does not exceed; 0 where there is none.
  [[nodiscard]] double quantile(double q) const;
  [[nodiscard]] double max() const { return max_; }

 private:
  static constexpr std::size_t classes = 2400;  // 1 µs times 1.01^2400 is over six hours
  std::array<std::uint64_t, classes> counts_{};
  std::uint64_t count_ = 0;
  double max_ = 0.0;
};

struct Summary {
  std::uint64_t frames = 0;     ///< that came, bad ones included
  std::uint64_t found = 0;      ///< instances: rows `found`
  std::uint64_t not_found = 0;  ///< rows `not_found`
  std::uint64_t bad = 0;        ///< bad frames
  std::uint64_t timed_out = 0;  ///< searches of a picture cut short by their timeout
  std::uint64_t dropped = 0;    ///< never searched because the search did not keep up (live only)
  std::uint64_t lost = 0;       ///< gaps in the numbers of live sources: frames that never came here
  TimeHistogram search_ms;      ///< a search of a frame or field for all patterns
  TimeHistogram latency_ms;     ///< from a frame's arrival to its result
  bool shows_latency = false;

  void add(const FrameResult& result);
  /// One line for stderr.
  [[nodiscard]] std::string text() const;
};

}  // namespace vsfind
