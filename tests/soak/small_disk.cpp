#include "tests/soak/small_disk.h"

#include <fcntl.h>
#include <sched.h>
#include <sys/mount.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <vector>

namespace vsfind::test {

SmallDisk::SmallDisk(const std::string& folder, std::uint64_t bytes, std::string& why_not) : folder_(folder) {
  const std::string size = "size=" + std::to_string(bytes);
  if (::unshare(CLONE_NEWNS) != 0 || ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
      ::mount("none", folder.c_str(), "tmpfs", 0, size.c_str()) != 0) {
    why_not = std::string("no file system can be mounted: ") + std::strerror(errno);
    return;
  }
  mounted_ = true;
}

SmallDisk::~SmallDisk() {
  if (mounted_) ::umount2(folder_.c_str(), MNT_DETACH);
}

void SmallDisk::fill() const {
  const int file = ::open((folder_ + "/filler").c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
  if (file < 0) return;
  std::vector<char> block(std::size_t{1} << 20U);
  for (std::size_t size = block.size(); size > 0; size /= 16) {
    while (::write(file, block.data(), size) > 0) {
    }
  }
  ::close(file);
}

void SmallDisk::make_room() const { ::unlink((folder_ + "/filler").c_str()); }

}  // namespace vsfind::test
