#include "calibration/pixel_aspect.h"

#include <charconv>
#include <optional>
#include <string_view>

#include "acquisition/errors.h"

namespace vsfind {
namespace {

// The whole of the text as a plain decimal number; from_chars because it does not look at the locale.
std::optional<double> whole_number(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

double pixel_aspect_from_text(const std::string& text) {
  if (text == "pal") return pal_pixel_aspect;
  if (text == "ntsc") return ntsc_pixel_aspect;
  const std::size_t colon = text.find(':');
  if (colon != std::string::npos) {
    const auto width = whole_number(std::string_view(text).substr(0, colon));
    const auto height = whole_number(std::string_view(text).substr(colon + 1));
    if (width && height && *width > 0.0 && *height > 0.0) {
      const double aspect = *width / *height;
      if (aspect >= 0.1 && aspect <= 10.0) return aspect;
      throw UsageError("pixel aspect '" + text.substr(0, 80) + "': out of range (allowed: W:H from 1:10 to 10:1)");
    }
  }
  throw UsageError("pixel aspect '" + text.substr(0, 80) +
                   "': not understood (allowed: pal, ntsc, or W:H as in 59:54)");
}

}  // namespace vsfind
