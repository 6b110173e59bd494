#include "app/source_mapping.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>

#include "acquisition/errors.h"
#include "calibration/calibration_file.h"

namespace vsfind {

void SourceMapping::check_size(int width, int height, Field field) const {
  if (calibration) check_fits(*calibration, width, height, field);
}

SourceMapping mapping_for(const std::string& source, const Ratio& said, const MappingChoice& choice) {
  SourceMapping chosen;
  if (!choice.calibration.empty()) {
    spdlog::info("{}: calibrated by {}", source, choice.calibration);
    chosen.calibration = load_calibration(choice.calibration);
    chosen.mapping = mapping_of(*chosen.calibration);
    chosen.unit = chosen.calibration->unit;
    chosen.asked_for = true;
    return chosen;
  }
  if (choice.pixel_aspect) {
    spdlog::info("{}: pixel aspect {} as given", source, choice.pixel_aspect->text);
    chosen.mapping = Mapping::from_pixel_aspect(choice.pixel_aspect->value);
    chosen.asked_for = true;
    return chosen;
  }
  if (!said.known()) {
    spdlog::info("{}: pixel aspect 1:1, as nothing else is said", source);
    return chosen;
  }
  spdlog::info("{}: pixel aspect {}:{} as the source says", source, said.numerator, said.denominator);
  try {
    chosen.mapping = Mapping::from_pixel_aspect(said.value());
  } catch (const UsageError& error) {
    throw IoError(fmt::format("{}: its pixel aspect {}:{} cannot be ({}); --pixel-aspect overrides it", source,
                              said.numerator, said.denominator, error.what()));
  }
  return chosen;
}

void check_units(const std::vector<std::shared_ptr<const Pattern>>& patterns, const SourceMapping& mapping) {
  for (const auto& pattern : patterns) {
    if (pattern->unit == mapping.unit) {
      constexpr double alike = 1e-3;
      const double aspect = mapping.mapping.pixel_aspect();
      if (!mapping.asked_for && std::abs(pattern->pixel_aspect / aspect - 1.0) > alike) {
        spdlog::warn(
            "the pattern '{}' was trained with pixel aspect {:.5g}, the pictures are taken to have {:.5g}: if that is "
            "not so, it looks distorted to the search; --pixel-aspect tells",
            pattern->name, pattern->pixel_aspect, aspect);
      }
      continue;
    }
    throw UsageError(
        fmt::format("the pattern '{}' was trained in {}, and the pictures are in {} (allowed: --calibration "
                    "with the same unit in training and search, or in neither)",
                    pattern->name, pattern->unit, mapping.unit));
  }
}

}  // namespace vsfind
