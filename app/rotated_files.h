#pragma once
/// @file
/// The names of files that were rotated away: rows.csv, begun at a time, becomes rows-20261124-175000.csv.

#include <cstddef>
#include <ctime>
#include <string>

namespace vsfind {

/// "rows.csv" and a time: "rows-20261124-175000.csv", local time.
[[nodiscard]] std::string rotated_name(const std::string& path, std::time_t time);

/// The N-th file of a series: "FILE-2.y4m" beside "FILE.y4m".
[[nodiscard]] std::string numbered_name(const std::string& path, int number);

/// Gives the file the rotated name of that time, or "rows-20261124-175000-2.csv" and so on where it is taken. Throws
/// std::filesystem::filesystem_error.
void rotate_away(const std::string& path, std::time_t time);

/// Removes the oldest of the files that were rotated away from `path`, by the times in their names, so that `keep` are
/// left. What cannot be removed is warned of. Returns how many were removed.
std::size_t remove_rotated(const std::string& path, std::size_t keep);

}  // namespace vsfind
