#include "acquisition/network_path.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <fstream>
#include <memory>

namespace vsfind {
namespace {

class Socket {
 public:
  Socket() : fd_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {}
  ~Socket() {
    if (fd_ >= 0) ::close(fd_);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  [[nodiscard]] int get() const { return fd_; }

 private:
  int fd_;
};

std::string dotted(const in_addr& address) {
  std::array<char, INET_ADDRSTRLEN> text{};
  return ::inet_ntop(AF_INET, &address, text.data(), text.size()) != nullptr ? text.data() : "";
}

struct FreeAddresses {
  void operator()(ifaddrs* list) const { ::freeifaddrs(list); }
};

}  // namespace

std::optional<NetworkPath> path_to(const std::string& address) {
  sockaddr_in there{};
  there.sin_family = AF_INET;
  there.sin_port = htons(9);  // any: nothing is sent
  if (::inet_pton(AF_INET, address.c_str(), &there.sin_addr) != 1) return std::nullopt;
  const Socket socket;
  sockaddr_in here{};
  socklen_t size = sizeof here;
  if (socket.get() < 0 || ::connect(socket.get(), reinterpret_cast<sockaddr*>(&there), sizeof there) != 0 ||
      ::getsockname(socket.get(), reinterpret_cast<sockaddr*>(&here), &size) != 0)
    return std::nullopt;

  NetworkPath path;
  path.address = dotted(here.sin_addr);
  ifaddrs* list = nullptr;
  if (::getifaddrs(&list) != 0) return std::nullopt;
  const std::unique_ptr<ifaddrs, FreeAddresses> owner(list);
  for (const ifaddrs* entry = list; entry != nullptr; entry = entry->ifa_next) {
    if (entry->ifa_addr == nullptr || entry->ifa_addr->sa_family != AF_INET) continue;
    const in_addr own = reinterpret_cast<const sockaddr_in*>(entry->ifa_addr)->sin_addr;
    const bool is_loopback = (entry->ifa_flags & IFF_LOOPBACK) != 0;
    if (own.s_addr == here.sin_addr.s_addr && path.interface.empty()) path.interface = entry->ifa_name;
    // Packets to any address of our own never leave this machine, whichever interface has it.
    if (own.s_addr == there.sin_addr.s_addr || (is_loopback && (ntohl(there.sin_addr.s_addr) >> 24U) == IN_LOOPBACKNET))
      path.loopback = true;
  }
  if (path.interface.empty()) return std::nullopt;
  ifreq request{};
  const std::string device = path.loopback ? "lo" : path.interface;
  device.copy(request.ifr_name, IFNAMSIZ - 1);
  if (::ioctl(socket.get(), SIOCGIFMTU, &request) == 0) path.mtu = request.ifr_mtu;
  return path;
}

bool is_ipv4_address(const std::string& text) {
  in_addr address{};
  return ::inet_pton(AF_INET, text.c_str(), &address) == 1;
}

bool answers_discovery(const std::string& address) {
  constexpr std::uint16_t port = 3956;
  sockaddr_in there{};
  there.sin_family = AF_INET;
  there.sin_port = htons(port);
  const Socket socket;
  if (socket.get() < 0 || ::inet_pton(AF_INET, address.c_str(), &there.sin_addr) != 1 ||
      ::connect(socket.get(), reinterpret_cast<sockaddr*>(&there), sizeof there) != 0)
    return false;
  constexpr int attempts = 3;
  constexpr int wait_ms = 200;
  for (int i = 0; i < attempts; ++i) {
    // Key, "acknowledge", DISCOVERY_CMD, no data, request number.
    const std::array<std::uint8_t, 8> command{0x42, 0x11, 0x00, 0x02,
                                              0x00, 0x00, 0x00, static_cast<std::uint8_t>(i + 1)};
    std::array<std::uint8_t, 600> answer{};
    pollfd waited{socket.get(), POLLIN, 0};
    const bool sent = ::send(socket.get(), command.data(), command.size(), MSG_NOSIGNAL) == ssize_t{command.size()};
    if (!sent || ::poll(&waited, 1, wait_ms) != 1) continue;
    const ssize_t size = ::recv(socket.get(), answer.data(), answer.size(), MSG_DONTWAIT);
    if (size < 8) continue;
    if (answer[2] == 0x00 && answer[3] == 0x03) return true;  // DISCOVERY_ACK
  }
  return false;
}

long max_receive_buffer() {
  std::ifstream file("/proc/sys/net/core/rmem_max");
  long bytes = 0;
  file >> bytes;
  return bytes;
}

}  // namespace vsfind
