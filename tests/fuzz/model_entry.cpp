#include <fmt/format.h>
#include <zlib.h>

#include <cstddef>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "acquisition/errors.h"
#include "finder/model_file.h"
#include "finder/search.h"
#include "tests/fuzz/entry_points.h"
#include "tests/fuzz/memory_file.h"

namespace vsfind::fuzz {
namespace {

/// The model with the checksum that its content ought to have, or "" where it is none: mutations would else never come
/// past the checksum.
std::string with_right_checksum(Bytes bytes) {
  if (bytes.size() > 16384) return {};  // writing recurses into what is nested
  auto file = nlohmann::ordered_json::parse(bytes.begin(), bytes.end(), nullptr, false);
  if (!file.is_object() || !file.contains("pattern")) return {};
  const std::string body = file["pattern"].dump();
  const auto* data = reinterpret_cast<const Bytef*>(body.data());
  file["checksum"] = fmt::format("{:08x}", crc32_z(crc32_z(0, nullptr, 0), data, body.size()));
  return file.dump();
}

void load_and_search(Bytes bytes) {
  const MemoryFile file(bytes);
  const auto pattern = std::make_shared<const Pattern>(load_model(file.path()));
  // A small picture with something in it.
  constexpr int width = 96;
  constexpr int height = 72;
  std::vector<std::byte> pixels(static_cast<std::size_t>(width) * height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const bool inside = x > 30 && x < 60 && y > 20 && y < 50;
      pixels[static_cast<std::size_t>(y * width + x)] = static_cast<std::byte>(inside ? 40 + x : 200 - y);
    }
  }
  SearchOptions options;
  options.timeout_ms = 200.0;
  Finder finder({pattern}, options);
  for (const auto& match : finder.find({pixels.data(), width, height, width, 8}, Mapping()).front().matches) {
    // A NaN is not equal to itself.
    if (match.score != match.score || match.pose.x != match.pose.x || match.pose.y != match.pose.y) {
      throw std::logic_error("a match that is no number");
    }
  }
}

}  // namespace

bool feed_model(Bytes bytes) {
  const auto refusing = [](Bytes given) {
    try {
      load_and_search(given);
    } catch (const UsageError&) {
      return false;
    } catch (const IoError&) {
      return false;
    }
    return true;
  };
  bool taken = refusing(bytes);
  std::string right;
  try {
    right = with_right_checksum(bytes);
  } catch (const nlohmann::json::exception&) {  // text that is no UTF-8 cannot be written again
  }
  if (!right.empty()) taken = refusing({reinterpret_cast<const std::uint8_t*>(right.data()), right.size()}) || taken;
  return taken;
}

}  // namespace vsfind::fuzz
