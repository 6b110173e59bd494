#include "app/progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace vsfind {
namespace {

std::size_t terminal_width() {
  winsize size{};
  constexpr std::size_t usual = 80;
  if (::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return usual;
  return size.ws_col;
}

std::string time_text(double seconds) {
  const auto s = static_cast<std::uint64_t>(std::llround(std::clamp(seconds, 0.0, 1e9)));
  constexpr std::uint64_t minute = 60;
  constexpr std::uint64_t hour = 3600;
  if (s < minute) return fmt::format("{} s", s);
  if (s < hour) return fmt::format("{}:{:02} min", s / minute, s % minute);
  return fmt::format("{}:{:02} h", s / hour, s % hour / minute);
}

}  // namespace

std::string progress_text(std::uint64_t done, std::optional<std::uint64_t> total, double seconds, std::size_t width) {
  const double rate = seconds > 0.0 ? static_cast<double>(done) / seconds : 0.0;
  if (!total || *total == 0) return fmt::format("{} frames, {:.1f}/s", done, rate).substr(0, width);
  const double part = std::min(1.0, static_cast<double>(done) / static_cast<double>(*total));
  std::string text = fmt::format(" {:3.0f}% {}/{} frames, {:.1f}/s", 100.0 * part, done, *total, rate);
  if (rate > 0.0) text += ", " + time_text(static_cast<double>(*total - std::min(done, *total)) / rate) + " left";
  constexpr std::size_t widest = 40;
  constexpr std::size_t narrowest = 8;
  if (text.size() + narrowest + 2 <= width) {
    const std::size_t bar = std::min(widest, width - text.size() - 2);
    const auto filled = static_cast<std::size_t>(part * static_cast<double>(bar));
    text = "[" + std::string(filled, '=') + std::string(bar - filled, ' ') + "]" + text;
  }
  return text.substr(0, width);
}

Progress::Progress(bool wanted, bool rows_on_stdout, std::optional<std::uint64_t> total)
    : shown_(wanted && ::isatty(STDERR_FILENO) == 1 && !(rows_on_stdout && ::isatty(STDOUT_FILENO) == 1)),
      total_(total),
      start_(std::chrono::steady_clock::now()) {}

Progress::~Progress() { clear(); }

void Progress::update(std::uint64_t done) {
  if (!shown_) return;
  const Time now = std::chrono::steady_clock::now();
  if (drawn_ && now - last_ < std::chrono::milliseconds(100)) return;
  last_ = now;
  drawn_ = true;
  const std::size_t width = terminal_width();
  const std::string text =
      progress_text(done, total_, std::chrono::duration<double>(now - start_).count(), width > 1 ? width - 1 : 1);
  fmt::print(stderr, "\r{}\x1b[K", text);
  std::fflush(stderr);
}

void Progress::clear() {
  if (!drawn_) return;
  drawn_ = false;
  fmt::print(stderr, "\r\x1b[K");
  std::fflush(stderr);
}

}  // namespace vsfind
