#include "tests/acquisition/gige_network.h"

#include <fcntl.h>
#include <sched.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <stdexcept>

extern char** environ;

namespace vsfind::test {
namespace {

bool run(const std::string& command) { return std::system((command + " >/dev/null 2>&1").c_str()) == 0; }

void write_text(const std::string& path, const std::string& text) { std::ofstream(path) << text; }

}  // namespace

std::string enter_own_network() {
  static bool entered = false;
  if (entered) return "";
  if (!run("ip -V")) return "the program ip (Debian: iproute2) is missing";
  if (::unshare(CLONE_NEWNET) != 0) {
    const std::string user = std::to_string(::getuid());
    const std::string group = std::to_string(::getgid());
    if (::unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0)
      return std::string("no network namespace can be made: ") + std::strerror(errno);
    write_text("/proc/self/setgroups", "deny");
    write_text("/proc/self/uid_map", "0 " + user + " 1");
    write_text("/proc/self/gid_map", "0 " + group + " 1");
  }
  if (!run("ip link set lo up && ip addr add 10.9.0.1/32 dev lo && ip addr add 10.9.0.2/32 dev lo"))
    return "the loopback interface of a new network namespace cannot be set up";
  entered = true;
  return "";
}

void set_link(bool up) {
  if (!run(std::string("ip link set lo ") + (up ? "up" : "down"))) throw std::runtime_error("ip link failed");
}

void set_mtu(int bytes) {
  if (!run("ip link set lo mtu " + std::to_string(bytes))) throw std::runtime_error("ip link failed");
}

GigeServer::GigeServer(const std::vector<std::string>& arguments) {
  int out[2];
  if (::pipe2(out, O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, out[1], STDOUT_FILENO);
  std::vector<std::string> words{VSFIND_GIGE_SERVER};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (auto& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  const int error = ::posix_spawn(&pid_, VSFIND_GIGE_SERVER, &actions, nullptr, pointers.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  ::close(out[1]);
  char text[16] = {};
  const ssize_t count = error == 0 ? ::read(out[0], text, sizeof text - 1) : 0;  // waits for it, or for its end
  ::close(out[0]);
  if (count <= 0 || std::string(text).rfind("ready", 0) != 0) throw std::runtime_error("gige_server does not start");
}

GigeServer::~GigeServer() { kill(); }

void GigeServer::kill() {
  if (pid_ <= 0) return;
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
  pid_ = -1;
}

void GigeServer::signal(int number) const {
  if (pid_ > 0) ::kill(pid_, number);
}

}  // namespace vsfind::test
