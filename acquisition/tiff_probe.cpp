#include "acquisition/tiff_probe.h"

#include <fmt/format.h>

#include <cstdint>

#include "acquisition/errors.h"
#include "acquisition/file_numbers.h"

namespace vsfind {
namespace {

/// The values of one entry of a TIFF directory.
struct TiffValues {
  std::uint64_t count = 0;
  std::uint64_t at = 0;
  unsigned size = 0;  ///< of each
  [[nodiscard]] std::uint64_t number(const FileNumbers& file, std::uint64_t i) const {
    return file.number(at + i * size, size);
  }
  [[nodiscard]] std::uint64_t first_or(const FileNumbers& file, std::uint64_t otherwise) const {
    return count > 0 ? number(file, 0) : otherwise;
  }
};

/// What the directory of a TIFF says of its first page, as far as it is looked at.
struct TiffPage {
  TiffValues width, height, photometric, samples, planes, rows_per_strip, offsets, byte_counts, tile_width, tile_height;
  [[nodiscard]] TiffValues* entry(std::uint64_t tag) {
    switch (tag) {
      case 256:
        return &width;
      case 257:
        return &height;
      case 262:
        return &photometric;
      case 277:
        return &samples;
      case 284:
        return &planes;
      case 278:
        return &rows_per_strip;
      case 273:
      case 324:
        return &offsets;
      case 279:
      case 325:
        return &byte_counts;
      case 322:
        return &tile_width;
      case 323:
        return &tile_height;
      default:
        return nullptr;
    }
  }
};

/// Every strip or tile that the picture needs is told, and lies in the file: what is not there the decoder would take
/// for black.
void check_tiff_strips(const FileNumbers& file, const TiffPage& page, const ImageProbe& probe) {
  const auto parts = [](std::int64_t whole, std::uint64_t part) {
    if (part == 0) throw IoError("is damaged: a TIFF strip of no size");
    return (static_cast<std::uint64_t>(whole) - 1) / part + 1;
  };
  std::uint64_t strips = page.tile_width.count > 0
                             ? parts(probe.width, page.tile_width.number(file, 0)) *
                                   parts(probe.height, page.tile_height.first_or(file, 0))
                             : parts(probe.height, page.rows_per_strip.first_or(file, ~std::uint64_t{0}));
  constexpr std::uint64_t separate = 2;
  if (page.planes.first_or(file, 1) == separate) strips *= page.samples.first_or(file, 1);
  if (page.offsets.count < strips)
    throw IoError(fmt::format("is damaged: {} of its {} TIFF strips are told", page.offsets.count, strips));
  for (std::uint64_t i = 0; i < strips; ++i) {
    const std::uint64_t offset = page.offsets.number(file, i);
    // Old files may lack the sizes.
    const std::uint64_t bytes = i < page.byte_counts.count ? page.byte_counts.number(file, i) : 1;
    if (bytes == 0) throw IoError(fmt::format("is damaged: TIFF strip {} is empty", i));
    if (offset > file.size() || file.size() - offset < bytes) throw IoError("is cut off");
  }
}

}  // namespace

ImageProbe probe_tiff(std::span<const std::byte> bytes) {
  const FileNumbers file(bytes, bytes[0] == std::byte{'I'});
  const bool big = file.number(2, 2) == 43;
  const unsigned word = big ? 8 : 4;
  const std::uint64_t directory = file.number(big ? 8 : 4, word);
  const std::uint64_t entries = file.number(directory, big ? 8 : 2);
  const std::uint64_t entry_size = big ? 20 : 12;
  if (entries > 65535) throw IoError("is damaged: the TIFF directory is too long");
  TiffPage page;
  for (std::uint64_t i = 0; i < entries; ++i) {
    const std::uint64_t at = directory + (big ? 8 : 2) + i * entry_size;
    const std::uint64_t tag = file.number(at, 2);
    const std::uint64_t type = file.number(at + 2, 2);
    TiffValues* const values = page.entry(tag);
    if (values == nullptr) continue;
    values->size = type == 3 ? 2 : type == 16 ? 8 : 4;
    values->count = file.number(at + 4, word);
    const std::uint64_t place = at + 4 + word;
    values->at = values->count <= word / values->size ? place : file.number(place, word);
  }
  // Without it the decoder prints lines of its own.
  if (page.photometric.count != 1 || page.photometric.size != 2)
    throw IoError("is damaged: the TIFF directory tells no photometric interpretation");
  ImageProbe probe{ImageFormat::tiff};
  probe.width = static_cast<std::int64_t>(page.width.first_or(file, 0));
  probe.height = static_cast<std::int64_t>(page.height.first_or(file, 0));
  if (probe.width > 0 && probe.height > 0) check_tiff_strips(file, page, probe);
  return probe;
}

}  // namespace vsfind
