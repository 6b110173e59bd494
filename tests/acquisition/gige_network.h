#pragma once
/// @file
/// A network of its own for GigE tests, with cameras on it: a network namespace whose only interface is the loopback,
/// so that nothing outside is reached and tests do not disturb each other.

#include <sys/types.h>

#include <string>
#include <vector>

namespace vsfind::test {

/// Moves this process (and what it starts) into a new namespace with 10.9.0.1 and 10.9.0.2 on its loopback interface;
/// once, before any thread is started. Returns "" or why it cannot be done.
[[nodiscard]] std::string enter_own_network();

/// Takes the loopback interface down or up.
void set_link(bool up);

/// Bytes of the loopback interface's largest packet; 65536 to begin with.
void set_mtu(int bytes);

/// A running gige_server; answers when the constructor returns.
class GigeServer {
 public:
  /// `arguments` as the program takes them: ADDRESS SERIAL WIDTHxHEIGHT FPS …
  explicit GigeServer(const std::vector<std::string>& arguments);
  ~GigeServer();
  GigeServer(const GigeServer&) = delete;
  GigeServer& operator=(const GigeServer&) = delete;
  /// Ends it like a power cut.
  void kill();
  /// SIGSTOP, say: it is there and does nothing.
  void signal(int number) const;

 private:
  pid_t pid_ = -1;
};

}  // namespace vsfind::test
