#pragma once
/// @file
/// Bytes as a file, for parsers that take a path.

#include <string>

#include "tests/fuzz/entry_points.h"

namespace vsfind::fuzz {

/// A file in memory that has a path as long as the object lives.
class MemoryFile {
 public:
  explicit MemoryFile(Bytes bytes);
  ~MemoryFile();
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  [[nodiscard]] std::string path() const;

 private:
  int fd_;
};

}  // namespace vsfind::fuzz
