#include "acquisition/byte_reader.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "acquisition/errors.h"

namespace vsfind {
namespace {

[[noreturn]] void fail(const std::string& path, const char* what, int error) {
  throw IoError(fmt::format("{}: {}: {}", path.empty() ? "''" : path, what, std::generic_category().message(error)));
}

}  // namespace

void UniqueFd::reset(int fd) noexcept {
  if (fd_ >= 0) ::close(fd_);
  fd_ = fd;
}

ByteReader::ByteReader(const std::string& path) : path_(path) {
  file_.reset(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file_.get() < 0) fail(path, "cannot be opened", errno);
  struct stat status {};
  if (::fstat(file_.get(), &status) != 0) fail(path, "cannot be opened", errno);
  if (S_ISDIR(status.st_mode)) fail(path, "cannot be opened", EISDIR);
  regular_ = S_ISREG(status.st_mode);
  if (regular_) {
    ::posix_fadvise(file_.get(), 0, 0, POSIX_FADV_SEQUENTIAL);
  } else {
    wake_.reset(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
    if (wake_.get() < 0) fail(path, "cannot be opened", errno);
  }
}

void ByteReader::stop() noexcept {
  stopped_.store(true, std::memory_order_release);
  const std::uint64_t one = 1;
  if (wake_.get() < 0) return;
  [[maybe_unused]] const ssize_t written = ::write(wake_.get(), &one, sizeof one);
}

std::size_t ByteReader::wait_and_read(std::byte* to, std::size_t size, std::byte* behind, std::size_t behind_size) {
  const std::array<iovec, 2> parts{{{to, size}, {behind, behind_size}}};
  for (;;) {
    if (stopped()) return 0;
    if (!regular_) {
      std::array<pollfd, 2> waiting{{{file_.get(), POLLIN, 0}, {wake_.get(), POLLIN, 0}}};
      if (::poll(waiting.data(), waiting.size(), -1) < 0) {
        if (errno != EINTR) fail(path_, "cannot be read", errno);
        continue;
      }
      if (stopped()) return 0;
      if (waiting[0].revents == 0) continue;
    }
    const ssize_t count = ::readv(file_.get(), parts.data(), behind_size > 0 ? 2 : 1);
    if (count >= 0) return static_cast<std::size_t>(count);
    if (errno != EINTR && errno != EAGAIN) fail(path_, "cannot be read", errno);
  }
}

std::size_t ByteReader::from_lookahead(std::byte* to, std::size_t size) {
  const std::size_t count = std::min(size, end_ - begin_);
  if (to != nullptr && count > 0) std::memcpy(to, lookahead_.data() + begin_, count);
  begin_ += count;
  position_ += count;
  return count;
}

std::size_t ByteReader::read(std::byte* to, std::size_t size) {
  std::size_t done = from_lookahead(to, size);
  while (done < size) {
    const std::size_t count = wait_and_read(to + done, size - done, lookahead_.data(), lookahead_.size());
    if (count == 0) break;
    const std::size_t taken = std::min(count, size - done);
    begin_ = 0;
    end_ = count - taken;
    done += taken;
    position_ += taken;
  }
  return done;
}

std::size_t ByteReader::skip(std::size_t size) {
  std::size_t done = from_lookahead(nullptr, size);
  const std::optional<std::uint64_t> rest = remaining();
  if (rest && done < size) {
    const std::size_t step = static_cast<std::size_t>(std::min<std::uint64_t>(size - done, *rest));
    if (::lseek(file_.get(), static_cast<off_t>(step), SEEK_CUR) < 0) fail(path_, "cannot be read", errno);
    position_ += step;
    return done + step;
  }
  std::array<std::byte, std::size_t{64} << 10U> scratch;
  while (done < size) {
    const std::size_t count = read(scratch.data(), std::min(scratch.size(), size - done));
    if (count == 0) break;
    done += count;
  }
  return done;
}

ByteReader::Line ByteReader::read_line() {
  for (;;) {
    const char* text = reinterpret_cast<const char*>(lookahead_.data()) + begin_;
    const std::size_t size = end_ - begin_;
    const std::string_view there(text, size);
    if (const std::size_t newline = there.find('\n'); newline != std::string_view::npos) {
      begin_ += newline + 1;
      position_ += newline + 1;
      return {LineStatus::whole, there.substr(0, newline)};
    }
    if (size == lookahead_.size()) return {LineStatus::too_long, there};
    // Not a whole line yet: what is there moves to the front, and reading goes on behind it.
    std::memmove(lookahead_.data(), text, size);
    begin_ = 0;
    end_ = size;
    const std::size_t count = wait_and_read(lookahead_.data() + end_, lookahead_.size() - end_, nullptr, 0);
    if (count == 0) return {LineStatus::ended, {reinterpret_cast<const char*>(lookahead_.data()), end_}};
    end_ += count;
  }
}

std::optional<std::uint64_t> ByteReader::remaining() const {
  if (!regular_) return std::nullopt;
  struct stat status {};
  if (::fstat(file_.get(), &status) != 0) fail(path_, "cannot be read", errno);
  const auto size = static_cast<std::uint64_t>(status.st_size);
  return size > position_ ? size - position_ : 0;
}

}  // namespace vsfind
