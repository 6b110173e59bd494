#include "app/source_mapping.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "acquisition/errors.h"

namespace vsfind {

Mapping mapping_for(const SourceInfo& source, const std::optional<PixelAspect>& given) {
  if (given) {
    spdlog::info("{}: pixel aspect {} as given", source.name, given->text);
    return Mapping::from_pixel_aspect(given->value);
  }
  const Ratio& said = source.pixel_aspect;
  if (!said.known()) {
    spdlog::info("{}: pixel aspect 1:1, as nothing else is said", source.name);
    return {};
  }
  spdlog::info("{}: pixel aspect {}:{} as the source says", source.name, said.numerator, said.denominator);
  try {
    return Mapping::from_pixel_aspect(said.value());
  } catch (const UsageError& error) {
    throw IoError(fmt::format("{}: its pixel aspect {}:{} cannot be: {}", source.name, said.numerator, said.denominator,
                              error.what()));
  }
}

}  // namespace vsfind
