#include "app/values.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>

#include "acquisition/errors.h"
#include "calibration/pixel_aspect.h"

namespace vsfind {
namespace {

template <typename T>
std::optional<T> number_in(std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  if constexpr (std::is_floating_point_v<T>) {
    if (!std::isfinite(value)) return std::nullopt;
  }
  return value;
}

std::vector<std::string_view> parts_of(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t at = text.find(separator);
    parts.push_back(text.substr(0, at));
    if (at == std::string_view::npos) return parts;
    text.remove_prefix(at + 1);
  }
}

std::string quoted(const std::string& text) {
  constexpr std::size_t longest = 80;  // enough to recognize it by
  return "'" + (text.size() > longest ? text.substr(0, longest) + "…" : text) + "'";
}

}  // namespace

double parse_number(const std::string& text, double min, double max) {
  const auto allowed = [&] {
    return max == std::numeric_limits<double>::infinity() ? fmt::format("a number of at least {:g}", min)
                                                          : fmt::format("a number from {:g} to {:g}", min, max);
  };
  const auto value = number_in<double>(text);
  if (!value) throw ValueError(fmt::format("{} is not a number (allowed: {})", quoted(text), allowed()));
  if (*value < min || *value > max) {
    throw ValueError(fmt::format("{} is out of range (allowed: {})", quoted(text), allowed()));
  }
  return *value;
}

int parse_whole(const std::string& text, int min, int max) {
  const auto allowed = [&] {
    return max == std::numeric_limits<int>::max() ? fmt::format("a whole number of at least {}", min)
                                                  : fmt::format("a whole number from {} to {}", min, max);
  };
  const auto value = number_in<int>(text);
  if (!value) throw ValueError(fmt::format("{} is not a whole number (allowed: {})", quoted(text), allowed()));
  if (*value < min || *value > max) {
    throw ValueError(fmt::format("{} is out of range (allowed: {})", quoted(text), allowed()));
  }
  return *value;
}

Range parse_range(const std::string& text, double lowest, double highest, const std::string& unit) {
  const std::string allowed = fmt::format("(allowed: MIN:MAX or one number{}{}, from {:g} to {:g})",
                                          unit.empty() ? "" : " in ", unit, lowest, highest);
  const auto parts = parts_of(text, ':');
  const auto first = number_in<double>(parts.front());
  const auto second = number_in<double>(parts.back());
  if (parts.size() > 2 || !first || !second) {
    throw ValueError(fmt::format("{} is not a range {}", quoted(text), allowed));
  }
  if (*first > *second)
    throw ValueError(fmt::format("{}: the minimum lies above the maximum {}", quoted(text), allowed));
  if (*first < lowest || *second > highest)
    throw ValueError(fmt::format("{} is out of range {}", quoted(text), allowed));
  return {*first, *second};
}

Roi parse_roi(const std::string& text) {
  const char* const allowed = "(allowed: X,Y,W,H in whole pixels, X and Y from 0, W and H from 1)";
  const auto parts = parts_of(text, ',');
  std::vector<int> values;
  for (const auto part : parts) {
    if (const auto value = number_in<int>(part)) values.push_back(*value);
  }
  if (parts.size() != 4 || values.size() != 4) {
    throw ValueError(fmt::format("{} is not a rectangle {}", quoted(text), allowed));
  }
  const Roi roi{values[0], values[1], values[2], values[3]};
  constexpr int limit = 1 << 20;  // no picture is larger; keeps sums of two far from overflow
  if (roi.x < 0 || roi.y < 0 || roi.width < 1 || roi.height < 1 || roi.x > limit || roi.y > limit ||
      roi.width > limit || roi.height > limit) {
    throw ValueError(fmt::format("{} is out of range {}", quoted(text), allowed));
  }
  return roi;
}

Eigen::Vector2d parse_point(const std::string& text) {
  const auto parts = parts_of(text, ',');
  const auto x = number_in<double>(parts.front());
  const auto y = number_in<double>(parts.back());
  if (parts.size() != 2 || !x || !y || std::abs(*x) > 1e6 || std::abs(*y) > 1e6) {
    throw ValueError(fmt::format("{} is not a point (allowed: X,Y in pixels)", quoted(text)));
  }
  return {*x, *y};
}

PixelAspect parse_pixel_aspect(const std::string& text) {
  try {
    return {pixel_aspect_from_text(text), text};
  } catch (const UsageError& error) {
    throw ValueError(error.what());
  }
}

bool parse_switch(const std::string& text) {
  return parse_word<bool>(text, {{"true", true}, {"false", false}, {"yes", true}, {"no", false}});
}

std::string parse_path(const std::string& text) {
  if (text.empty()) throw ValueError("'' is not a file or folder name");
  if (text.find('\0') != std::string::npos) throw ValueError("a file or folder name cannot hold a zero byte");
  return text;
}

}  // namespace vsfind
