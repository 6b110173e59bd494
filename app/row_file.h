#pragma once
/// @file
/// The file of rows that a run of months writes: rotated by size or day, and going on after a full disk.

#include <cstddef>
#include <cstdint>
#include <ctime>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "app/output_file.h"

namespace vsfind {

struct RowFileOptions {
  std::uint64_t max_bytes = 0;  ///< a file is rotated before it grows beyond this; 0: any size
  bool daily = false;           ///< a file is rotated at midnight, local time
  std::size_t keep = 0;         ///< so many of the files rotated away are kept, the oldest are removed; 0: all
  /// A line that cannot be written is counted, told of once, and lost, instead of ending the run. Not for stdout, whose
  /// reader has gone.
  bool keep_going = false;
  std::function<std::time_t()> now = [] { return std::time(nullptr); };

  [[nodiscard]] bool rotates() const { return max_bytes > 0 || daily; }
};

/// Lines, each written at once (output_file.h). The file being written always has the name given; what is rotated away
/// gets the time at which it was begun into its name (rotated_files.h).
class RowFile {
 public:
  /// Creates or empties `path` and writes `header`, if it is not empty, as every file's first line; "-" is stdout. With
  /// rotation, what stands in an earlier file of that name is kept: it is rotated away. Throws IoError.
  RowFile(std::string path, std::string header, RowFileOptions options = {});

  /// Throws IoError unless told to keep going.
  void write_line(std::string_view line);

  /// Lines that could not be written.
  [[nodiscard]] std::uint64_t lost() const { return lost_; }

 private:
  void begin();
  void rotate();
  [[nodiscard]] bool is_due(std::size_t more) const;

  std::string path_;
  std::string header_;
  RowFileOptions options_;
  std::optional<OutputFile> file_;
  std::uint64_t bytes_ = 0;
  std::time_t begun_ = 0;
  std::time_t ends_ = 0;  // of the day
  std::uint64_t lost_ = 0;
  std::uint64_t lost_in_a_row_ = 0;
};

}  // namespace vsfind
