#pragma once
/// @file
/// Numbers out of the bytes of a file that may be damaged.

#include <cstddef>
#include <cstdint>
#include <span>

#include "acquisition/errors.h"

namespace vsfind {

/// Numbers out of bytes, never beyond their end: IoError("is cut off") there. Does not own the bytes.
class FileNumbers {
 public:
  FileNumbers(std::span<const std::byte> bytes, bool little) : bytes_(bytes), little_(little) {}

  [[nodiscard]] std::uint64_t number(std::uint64_t at, unsigned size) const {
    if (at > bytes_.size() || bytes_.size() - at < size) throw IoError("is cut off");
    std::uint64_t value = 0;
    for (unsigned i = 0; i < size; ++i) {
      const auto byte = std::to_integer<std::uint64_t>(bytes_[at + (little_ ? size - 1 - i : i)]);
      value = value << 8U | byte;
    }
    return value;
  }
  [[nodiscard]] std::uint64_t size() const { return bytes_.size(); }

 private:
  std::span<const std::byte> bytes_;
  bool little_;
};

}  // namespace vsfind
