#pragma once
/// @file
/// Which way packets to an address take, as the kernel's routes say.

#include <optional>
#include <string>

namespace vsfind {

struct NetworkPath {
  std::string address;    ///< our own, dotted: packets to there leave with it
  std::string interface;  ///< its name: "eth0"
  int mtu = 0;            ///< bytes of an IP packet
  bool loopback = false;  ///< the other end is this machine itself
};

/// The way to a dotted IPv4 address; nothing where there is none.
[[nodiscard]] std::optional<NetworkPath> path_to(const std::string& address);

[[nodiscard]] bool is_ipv4_address(const std::string& text);

/// Whether a GigE Vision device at a dotted address answers a discovery (GVCP, port 3956); asks three times within
/// 0.6 seconds.
[[nodiscard]] bool answers_discovery(const std::string& address);

/// The kernel's limit of a socket's receive buffer in bytes, 0 where it does not say.
[[nodiscard]] long max_receive_buffer();

}  // namespace vsfind
