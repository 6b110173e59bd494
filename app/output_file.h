#pragma once
/// @file
/// A file or stdout that is written a whole line at a time.

#include <cstdint>
#include <string>
#include <string_view>

namespace vsfind {

/// Every line is one write(2), so that a kill at any moment leaves whole lines only. Move-only.
class OutputFile {
 public:
  /// Creates or empties `path`; "-" is stdout. Throws IoError.
  explicit OutputFile(const std::string& path);
  ~OutputFile();
  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&& other) noexcept;

  /// Writes `line` and a newline. Where the disk is full a part already written is taken back. Throws IoError.
  void write_line(std::string_view line);
  /// Writes bytes as they are.
  void write(std::string_view bytes);

  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
  int descriptor_ = -1;
  std::string buffer_;
};

}  // namespace vsfind
