#include "app/summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace vsfind {
namespace {

constexpr double first_ms = 0.001;
const double log_step = std::log(1.01);

}  // namespace

void TimeHistogram::add(double ms) {
  const double place = ms > first_ms ? std::log(ms / first_ms) / log_step : 0.0;
  ++counts_[static_cast<std::size_t>(std::clamp(place, 0.0, static_cast<double>(classes - 1)))];
  ++count_;
  max_ = std::max(max_, ms);
}

double TimeHistogram::quantile(double q) const {
  if (count_ == 0) return 0.0;
  const auto wanted = static_cast<std::uint64_t>(std::ceil(std::clamp(q, 0.0, 1.0) * static_cast<double>(count_)));
  std::uint64_t seen = 0;
  for (std::size_t i = 0; i < classes; ++i) {
    seen += counts_[i];
    // The middle of the class, which cannot lie above the largest of all.
    if (seen >= std::max<std::uint64_t>(wanted, 1)) {
      return std::min(max_, first_ms * std::exp((static_cast<double>(i) + 0.5) * log_step));
    }
  }
  return max_;
}

void Summary::add(const FrameResult& result) {
  ++frames;
  if (result.info.status != FrameStatus::good) ++bad;
  for (const auto& picture : result.pictures) {
    search_ms.add(picture.search_ms);
    const bool cut_short = std::any_of(picture.patterns.begin(), picture.patterns.end(),
                                       [](const PatternMatches& each) { return each.timed_out; });
    if (cut_short) ++timed_out;
    for (const auto& pattern : picture.patterns) {
      found += pattern.matches.size();
      if (pattern.matches.empty()) ++not_found;
    }
  }
}

std::string Summary::text() const {
  std::string text = fmt::format("{} frames: {} found, {} not found, {} bad", frames, found, not_found, bad);
  if (timed_out > 0) text += fmt::format(", {} timed out", timed_out);
  if (dropped > 0) text += fmt::format(", {} dropped", dropped);
  if (lost > 0) text += fmt::format(", {} lost before they came", lost);
  if (search_ms.count() > 0) {
    text += fmt::format("; search time median {:.3f} ms, 99th percentile {:.3f} ms, maximum {:.3f} ms",
                        search_ms.quantile(0.5), search_ms.quantile(0.99), search_ms.max());
  }
  if (shows_latency && latency_ms.count() > 0) {
    text += fmt::format("; latency median {:.3f} ms, 99th percentile {:.3f} ms, maximum {:.3f} ms",
                        latency_ms.quantile(0.5), latency_ms.quantile(0.99), latency_ms.max());
  }
  return text;
}

}  // namespace vsfind
