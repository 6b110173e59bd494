#include "app/output_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "acquisition/errors.h"

namespace vsfind {
namespace {

std::string shown(const std::string& path) { return path == "-" ? "stdout" : path; }

}  // namespace

OutputFile::OutputFile(const std::string& path) : path_(path) {
  if (path == "-") {
    descriptor_ = STDOUT_FILENO;
    return;
  }
  constexpr mode_t permissions = 0666;
  descriptor_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, permissions);
  if (descriptor_ < 0) throw IoError(path + ": cannot be opened for writing: " + std::strerror(errno));
}

OutputFile::~OutputFile() {
  if (descriptor_ >= 0 && path_ != "-") ::close(descriptor_);
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      buffer_(std::move(other.buffer_)) {}

OutputFile& OutputFile::operator=(OutputFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(descriptor_, other.descriptor_);
  std::swap(buffer_, other.buffer_);
  return *this;
}

void OutputFile::write_line(std::string_view line) {
  buffer_.assign(line);
  buffer_ += '\n';
  write(buffer_);
}

void OutputFile::write(std::string_view bytes) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count = ::write(descriptor_, bytes.data() + done, bytes.size() - done);
    if (count >= 0) {
      done += static_cast<std::size_t>(count);
      continue;
    }
    if (errno == EINTR) continue;
    const int reason = errno;
    struct stat status {};
    if (done > 0 && ::fstat(descriptor_, &status) == 0 && S_ISREG(status.st_mode)) {
      // Part of a line helps nobody who reads the file afterwards. Failing to take it back changes nothing.
      const off_t end = ::lseek(descriptor_, 0, SEEK_CUR);
      if (end >= static_cast<off_t>(done)) {
        [[maybe_unused]] const int ignored = ::ftruncate(descriptor_, end - static_cast<off_t>(done));
        ::lseek(descriptor_, end - static_cast<off_t>(done), SEEK_SET);  // or the next line would leave a hole
      }
    }
    throw IoError(shown(path_) + ": cannot be written: " + std::strerror(reason));
  }
}

}  // namespace vsfind
