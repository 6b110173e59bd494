#pragma once
/// @file
/// The words in which options are given, on the command line and in a configuration alike: text to value.
/// Each throws ValueError with the offending text, what is wrong and what is allowed.

#include <Eigen/Core>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/image_view.h"
#include "finder/pose.h"

namespace vsfind {

/// A value that cannot be taken. Whoever knows where it stood (option, or file, line and key) puts that before it.
struct ValueError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Pixel width over pixel height, with the words that it came from.
struct PixelAspect {
  double value = 1.0;
  std::string text = "1:1";
};

/// What is searched of an interlaced frame.
enum class FieldMode { frame, top, bottom, split };
[[nodiscard]] constexpr const char* name(FieldMode mode) {
  return mode == FieldMode::top      ? "top"
         : mode == FieldMode::bottom ? "bottom"
         : mode == FieldMode::split  ? "split"
                                     : "frame";
}

/// A number of [min, max], '.' as the decimal point whatever the locale.
[[nodiscard]] double parse_number(const std::string& text, double min, double max);
/// A whole number of [min, max].
[[nodiscard]] int parse_whole(const std::string& text, int min, int max);
/// `MIN:MAX`, or one number for both ends; both of [lowest, highest]. `unit` is named in complaints ("degrees").
[[nodiscard]] Range parse_range(const std::string& text, double lowest, double highest, const std::string& unit);
/// `X,Y,W,H` in whole pixels, W and H at least 1.
[[nodiscard]] Roi parse_roi(const std::string& text);
/// `X,Y` in pixels.
[[nodiscard]] Eigen::Vector2d parse_point(const std::string& text);
/// `W:H`, `pal` or `ntsc`, as pixel_aspect_from_text.
[[nodiscard]] PixelAspect parse_pixel_aspect(const std::string& text);
[[nodiscard]] bool parse_switch(const std::string& text);
[[nodiscard]] std::string parse_path(const std::string& text);

/// One of a few words, each standing for a value.
template <typename T>
[[nodiscard]] T parse_word(const std::string& text, const std::vector<std::pair<std::string, T>>& words);

}  // namespace vsfind

// ---- details -------------------------------------------------------------------------------------------------------

#include "app/nearest.h"

namespace vsfind {

template <typename T>
T parse_word(const std::string& text, const std::vector<std::pair<std::string, T>>& words) {
  std::vector<std::string> known;
  std::string allowed;
  for (const auto& [word, value] : words) {
    if (word == text) return value;
    known.push_back(word);
    allowed += (allowed.empty() ? "" : ", ") + word;
  }
  throw ValueError("'" + text + "' is not known" + did_you_mean(text, known) + " (allowed: " + allowed + ")");
}

}  // namespace vsfind
