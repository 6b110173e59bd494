#pragma once
/// @file
/// A progress bar on stderr, if that is a terminal.

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

namespace vsfind {

/// The bar as text, at most `width` characters: part done, frames, rate, time left. Without a known total: frames and
/// rate only.
[[nodiscard]] std::string progress_text(std::uint64_t done, std::optional<std::uint64_t> total, double seconds,
                                        std::size_t width);

class Progress {
 public:
  /// Shows nothing unless stderr is a terminal, `wanted`, and no rows go to the same terminal.
  Progress(bool wanted, bool rows_on_stdout, std::optional<std::uint64_t> total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Draws ten times a second at most.
  void update(std::uint64_t done);
  /// Clears the line, so that other text can follow.
  void clear();

 private:
  using Time = std::chrono::steady_clock::time_point;
  bool shown_;
  bool drawn_ = false;
  std::optional<std::uint64_t> total_;
  Time start_;
  Time last_;
};

}  // namespace vsfind
