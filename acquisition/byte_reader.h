#pragma once
/// @file
/// A file read from front to end: regular files, pipes and devices alike.

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace vsfind {

/// A file descriptor that closes itself.
class UniqueFd {
 public:
  UniqueFd() = default;
  explicit UniqueFd(int fd) : fd_(fd) {}
  UniqueFd(UniqueFd&& other) noexcept : fd_(other.release()) {}
  UniqueFd& operator=(UniqueFd&& other) noexcept {
    reset(other.release());
    return *this;
  }
  UniqueFd(const UniqueFd&) = delete;
  UniqueFd& operator=(const UniqueFd&) = delete;
  ~UniqueFd() { reset(); }
  [[nodiscard]] int get() const { return fd_; }
  void reset(int fd = -1) noexcept;

  /// Gives the descriptor up without closing it.
  int release() noexcept {
    const int fd = fd_;
    fd_ = -1;
    return fd;
  }

 private:
  int fd_ = -1;
};

/// Reads lines and blocks of bytes. Blocks go from the kernel straight to where they are wanted, together with the
/// line that follows, in one call.
class ByteReader {
 public:
  /// Throws IoError naming the file.
  explicit ByteReader(const std::string& path);

  /// The bytes up to the next newline, which is taken too and is not part of them; valid until the next call.
  /// `ended` where the file ends first, `too_long` where no newline comes within `line_capacity` bytes; the bytes are
  /// then those that are there. Throws IoError where reading fails.
  enum class LineStatus { whole, ended, too_long };
  struct Line {
    LineStatus status;
    std::string_view text;
  };
  [[nodiscard]] Line read_line();

  /// Fills `size` bytes; returns how many there were before the end of the file. Throws IoError.
  [[nodiscard]] std::size_t read(std::byte* to, std::size_t size);
  /// Passes over `size` bytes; returns how many there were. Throws IoError.
  [[nodiscard]] std::size_t skip(std::size_t size);

  /// Bytes from here to the present end of a regular file; nothing for pipes and devices.
  [[nodiscard]] std::optional<std::uint64_t> remaining() const;
  /// Bytes taken so far.
  [[nodiscard]] std::uint64_t position() const { return position_; }
  /// The file, for positioned reads of a regular file.
  [[nodiscard]] int fd() const { return file_.get(); }

  /// Makes a waiting and every later read end as at the end of the file.
  void stop() noexcept;
  [[nodiscard]] bool stopped() const { return stopped_.load(std::memory_order_acquire); }

  static constexpr std::size_t line_capacity = 1024;

 private:
  /// Waits, then reads into `to` and on into `behind`; the bytes read, 0 at the end.
  std::size_t wait_and_read(std::byte* to, std::size_t size, std::byte* behind, std::size_t behind_size);
  [[nodiscard]] std::size_t from_lookahead(std::byte* to, std::size_t size);

  std::string path_;
  UniqueFd file_;
  UniqueFd wake_;  // an eventfd that ends waiting for a pipe
  bool regular_ = false;
  std::uint64_t position_ = 0;
  std::array<std::byte, line_capacity> lookahead_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::atomic<bool> stopped_ = false;
};

}  // namespace vsfind
