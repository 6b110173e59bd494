#include "tests/soak/slow_reader.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <stdexcept>
#include <utility>

namespace vsfind::test {

SlowReader::SlowReader(const std::string& path, std::function<void(const std::string&)> line) : line_(std::move(line)) {
  if (::mkfifo(path.c_str(), 0600) != 0) throw std::runtime_error(path + ": no pipe can be made");
  // Without waiting for a writer, which would wait for a reader.
  file_ = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (file_ < 0) throw std::runtime_error(path + ": cannot be opened");
  // As small as it gets, so that a pause is felt soon.
  ::fcntl(file_, F_SETPIPE_SZ, 4096);
  thread_ = std::thread([this] { run(); });
}

SlowReader::~SlowReader() {
  static_cast<void>(finish());
  ::close(file_);
}

std::string SlowReader::finish() {
  ending_ = true;
  if (thread_.joinable()) thread_.join();
  return rest_;
}

void SlowReader::run() {
  while (true) {
    if (paused_ && !ending_) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      continue;
    }
    std::array<char, 4096> bytes{};
    const ssize_t count = ::read(file_, bytes.data(), bytes.size());
    if (count <= 0) {
      // Nothing there; at the end of a writer that is gone nothing comes any more.
      if (ending_) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      continue;
    }
    rest_.append(bytes.data(), static_cast<std::size_t>(count));
    std::size_t begin = 0;
    for (std::size_t end; (end = rest_.find('\n', begin)) != std::string::npos; begin = end + 1)
      line_(rest_.substr(begin, end - begin));
    rest_.erase(0, begin);
  }
}

}  // namespace vsfind::test
