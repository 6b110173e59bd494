#include "app/rotated_files.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

namespace vsfind {
namespace {

namespace fs = std::filesystem;

/// The time and the number of a name that rotate_away() gives; nothing where it is none.
std::optional<std::pair<std::string, int>> rotation_of(std::string_view name, const fs::path& plain) {
  const std::string begin = plain.stem().string() + "-";
  const std::string end = plain.extension().string();
  constexpr std::string_view form = "dddddddd-dddddd";
  if (!name.starts_with(begin) || !name.ends_with(end) || name.size() < begin.size() + form.size() + end.size())
    return std::nullopt;
  const std::string_view middle = name.substr(begin.size(), name.size() - begin.size() - end.size());
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  for (std::size_t i = 0; i < form.size(); ++i) {
    if (form[i] == 'd' ? !is_digit(middle[i]) : middle[i] != form[i]) return std::nullopt;
  }
  std::string_view rest = middle.substr(form.size());
  int number = 1;
  if (!rest.empty()) {
    if (rest[0] != '-' || rest.size() < 2 || !is_digit(rest[1])) return std::nullopt;
    rest.remove_prefix(1);
    const auto [stop, error] = std::from_chars(rest.data(), rest.data() + rest.size(), number);
    if (error != std::errc{} || stop != rest.data() + rest.size()) return std::nullopt;
  }
  return std::pair(std::string(middle.substr(0, form.size())), number);
}

}  // namespace

std::string rotated_name(const std::string& path, std::time_t time) {
  std::tm parts{};
  ::localtime_r(&time, &parts);
  const fs::path plain(path);
  return (plain.parent_path() /
          fmt::format("{}-{:%Y%m%d-%H%M%S}{}", plain.stem().string(), parts, plain.extension().string()))
      .string();
}

std::string numbered_name(const std::string& path, int number) {
  const fs::path plain(path);
  return (plain.parent_path() / fmt::format("{}-{}{}", plain.stem().string(), number, plain.extension().string()))
      .string();
}

void rotate_away(const std::string& path, std::time_t time) {
  const std::string first = rotated_name(path, time);
  std::string to = first;
  for (int i = 2; fs::exists(to); ++i) to = numbered_name(first, i);
  fs::rename(path, to);
}

std::size_t remove_rotated(const std::string& path, std::size_t keep) {
  const fs::path plain(path);
  const fs::path folder = plain.has_parent_path() ? plain.parent_path() : fs::path(".");
  std::vector<std::pair<std::pair<std::string, int>, fs::path>> rotated;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code ignored;
    if (!entry->is_regular_file(ignored)) continue;
    if (auto when = rotation_of(entry->path().filename().string(), plain))
      rotated.emplace_back(std::move(*when), entry->path());
  }
  if (rotated.size() <= keep) return 0;
  std::sort(rotated.begin(), rotated.end());
  std::size_t removed = 0;
  for (std::size_t i = 0; i < rotated.size() - keep; ++i) {
    if (fs::remove(rotated[i].second, error)) {
      ++removed;
    } else if (error) {
      spdlog::warn("{}: is too old, and cannot be removed: {}", rotated[i].second.string(), error.message());
    }
  }
  return removed;
}

}  // namespace vsfind
