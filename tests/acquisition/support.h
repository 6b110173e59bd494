#pragma once
/// @file
/// What the tests of this room share: a folder that goes away, pictures whose every pixel is known, files in bytes.

#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/image_view.h"

namespace vsfind::test {

/// A new folder, removed with all that is in it.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "vsfind-acquisition-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    path_ = name;
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  [[nodiscard]] std::string file(const std::string& name) const { return (path_ / name).string(); }
  [[nodiscard]] std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

/// A picture whose pixels are a hash of seed, position and bits, so that no two rows, columns or frames agree; with
/// `padding` bytes behind every row.
class Picture {
 public:
  Picture(int width, int height, int bits, std::uint32_t seed, int padding = 0) {
    const int bytes = bits > 8 ? 2 : 1;
    const int stride = width * bytes + padding;
    memory_.resize((static_cast<std::size_t>(stride) * static_cast<std::size_t>(height) + 1) / 2);
    view_ = {reinterpret_cast<const std::byte*>(memory_.data()), width, height, stride, bits};
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) set(x, y, value(x, y, bits, seed));
    }
  }
  [[nodiscard]] const ImageView& view() const { return view_; }
  void set(int x, int y, std::uint16_t grey) {
    auto* row = reinterpret_cast<std::uint8_t*>(memory_.data()) + y * view_.stride;
    if (view_.bits > 8) {
      reinterpret_cast<std::uint16_t*>(row)[x] = grey;
    } else {
      row[x] = static_cast<std::uint8_t>(grey);
    }
  }
  static std::uint16_t value(int x, int y, int bits, std::uint32_t seed) {
    std::uint32_t hash =
        seed * 2654435761U ^ static_cast<std::uint32_t>(x) * 40503U ^ static_cast<std::uint32_t>(y) * 2246822519U;
    hash = (hash ^ hash >> 15U) * 2246822519U;
    return static_cast<std::uint16_t>((hash ^ hash >> 13U) & ((1U << static_cast<unsigned>(bits)) - 1U));
  }

 private:
  std::vector<std::uint16_t> memory_;
  ImageView view_;
};

/// Whether two pictures agree in size, bits and every pixel.
inline bool same_pixels(const ImageView& a, const ImageView& b) {
  if (a.empty() || b.empty()) return a.empty() && b.empty();
  if (a.width != b.width || a.height != b.height || a.bits != b.bits) return false;
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      if (a.at(x, y) != b.at(x, y)) return false;
    }
  }
  return true;
}

inline std::string read_bytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline void write_bytes(const std::string& path, std::string_view bytes) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!file.flush()) throw std::runtime_error("cannot write " + path);
}

/// The text of the `Error` that `action` throws; empty where it throws none.
template <typename Error, typename Action>
std::string complaint(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

}  // namespace vsfind::test
