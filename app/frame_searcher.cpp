#include "app/frame_searcher.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <set>

#include "acquisition/errors.h"
#include "finder/model_file.h"

namespace vsfind {

GreyPicture grey_picture(const ImageView& image) {
  GreyPicture grey{image.width, image.height, {}};
  const auto width = static_cast<std::size_t>(image.width);
  grey.pixels.resize(width * static_cast<std::size_t>(image.height));
  for (int y = 0; y < image.height; ++y) {
    std::uint8_t* const to = grey.pixels.data() + static_cast<std::size_t>(y) * width;
    if (image.bits <= 8) {
      std::copy_n(image.row8(y), width, to);
      continue;
    }
    const std::uint16_t* const from = image.row16(y);
    for (std::size_t x = 0; x < width; ++x) to[x] = static_cast<std::uint8_t>(from[x] >> (image.bits - 8));
  }
  return grey;
}

std::vector<Field> searched_fields(FieldMode mode, const FrameInfo& info) {
  if (info.field != Field::frame) {
    const bool other = (mode == FieldMode::top && info.field != Field::top) ||
                       (mode == FieldMode::bottom && info.field != Field::bottom);
    if (other) return {};
    return {info.field};
  }
  switch (mode) {
    case FieldMode::frame:
      return {Field::frame};
    case FieldMode::top:
      return {Field::top};
    case FieldMode::bottom:
      return {Field::bottom};
    case FieldMode::split:
      break;
  }
  if (info.order == FieldOrder::bottom_first) return {Field::bottom, Field::top};
  return {Field::top, Field::bottom};
}

void check_region(const SearchOptions& options, int width, int height, const std::string& source) {
  if (!options.region || width <= 0 || height <= 0) return;
  const Roi& r = *options.region;
  if (r.x >= width || r.y >= height) {
    throw UsageError(fmt::format("--region {},{},{},{} lies outside {} (allowed: within its {}x{} pixels)", r.x, r.y,
                                 r.width, r.height, source, width, height));
  }
}

FrameSearcher::FrameSearcher(std::vector<std::shared_ptr<const Pattern>> patterns, const RunOptions& options,
                             SourceMapping mapping)
    : finder_(std::move(patterns), options.search),
      search_(options.search),
      mode_(options.field),
      keep_pictures_(!options.overlay.empty() || !options.report.empty()) {
  set_mapping(std::move(mapping));
}

void FrameSearcher::set_mapping(SourceMapping mapping) {
  check_units(finder_.patterns(), mapping);
  mapping_ = std::make_shared<const SourceMapping>(std::move(mapping));
}

FrameResult FrameSearcher::unsearched(const std::string& source, const FrameInfo& info) const {
  FrameResult result;
  result.patterns = &finder_.patterns();
  result.mapping = mapping_;
  result.source = source;
  result.info = info;
  return result;
}

FrameResult FrameSearcher::search(const std::string& source, const FrameInfo& info, const ImageView& image) {
  FrameResult result = unsearched(source, info);
  if (info.status != FrameStatus::good) return result;
  mapping_->check_size(image.width, image.height, info.field);
  check_region(search_, image.width, image.height * line_step(info.field), source);
  for (const Field field : searched_fields(mode_, info)) {
    // A frame that is a single field already has that field's lines only.
    const ImageView view = info.field == Field::frame ? field_view(image, field) : image;
    PictureResult& picture = result.pictures.emplace_back();
    picture.field = field;
    picture.patterns = finder_.find(view, mapping_->mapping.for_field(field));
    picture.search_ms = finder_.search_ms();
    if (keep_pictures_) picture.grey = grey_picture(view);
  }
  return result;
}

std::vector<std::shared_ptr<const Pattern>> load_models(const std::vector<std::string>& paths) {
  std::vector<std::shared_ptr<const Pattern>> patterns;
  std::set<std::string> names;
  for (const auto& path : paths) {
    patterns.push_back(std::make_shared<const Pattern>(load_model(path)));
    if (!names.insert(patterns.back()->name).second) {
      spdlog::warn("{}: another model is called '{}' too; their rows cannot be told apart", path,
                   patterns.back()->name);
    }
  }
  return patterns;
}

}  // namespace vsfind
