#pragma once
/// @file
/// The picture that the GigE server shows where it is given none: every byte follows from the frame's id.

#include <cstddef>
#include <cstdint>

namespace vsfind::test {

inline void fill_numbered(std::byte* bytes, std::size_t size, std::uint32_t id) {
  std::uint32_t state = id * 2654435761U | 1U;
  for (std::size_t i = 0; i < size; ++i) {
    if (i % 4 == 0) {  // xorshift
      state ^= state << 13U;
      state ^= state >> 17U;
      state ^= state << 5U;
    }
    bytes[i] = static_cast<std::byte>(state >> 8U * (i % 4));
  }
  for (std::size_t i = 0; i < 4 && i < size; ++i) bytes[i] = static_cast<std::byte>(id >> 8U * i);
}

/// The id that a picture shows.
inline std::uint32_t number_shown(const std::byte* bytes) {
  std::uint32_t id = 0;
  for (unsigned i = 0; i < 4; ++i) id |= static_cast<std::uint32_t>(bytes[i]) << 8U * i;
  return id;
}

}  // namespace vsfind::test
