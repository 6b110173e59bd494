#pragma once
/// @file
/// A disk that is full when one likes.

#include <cstdint>
#include <string>

namespace vsfind::test {

/// A file system of its own in memory, of so many bytes, mounted on a folder for this process and what it starts.
class SmallDisk {
 public:
  /// Before any thread is started. `why_not` is empty where it worked.
  SmallDisk(const std::string& folder, std::uint64_t bytes, std::string& why_not);
  ~SmallDisk();
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

  /// Takes all the room that is left, and gives it back.
  void fill() const;
  void make_room() const;

 private:
  std::string folder_;
  bool mounted_ = false;
};

}  // namespace vsfind::test
