#include "tests/acquisition/vivid/guest_run.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <exception>
#include <fstream>
#include <stdexcept>
#include <thread>

#include "app/program.h"

namespace vsfind::test {
namespace {

int ready_pipe = -1;

void redirect(int descriptor, const std::string& file) {
  const int fd = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  ::dup2(fd, descriptor);
  ::close(fd);
}

}  // namespace

void wait_until(const std::string& what, bool (*condition)(const void*), const void* state) {
  using Clock = std::chrono::steady_clock;
  constexpr auto patience = std::chrono::seconds(30);
  constexpr auto pause = std::chrono::milliseconds(20);
  for (const auto end = Clock::now() + patience; !condition(state); std::this_thread::sleep_for(pause)) {
    if (Clock::now() > end) throw std::runtime_error(what + ": not within half a minute");
  }
}

GuestRun::GuestRun(const std::string& folder, const std::string& name, const std::vector<std::string>& arguments)
    : path_(folder + "/" + name), pid_(::fork()) {
  if (pid_ < 0) throw std::runtime_error("no process can be made");
  if (pid_ > 0) return;
  redirect(STDOUT_FILENO, path_ + ".out");
  redirect(STDERR_FILENO, path_ + ".err");
  const int code = run_program(arguments);
  std::fflush(nullptr);
  ::_exit(code);
}

GuestRun::~GuestRun() {
  if (pid_ <= 0) return;
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
}

void GuestRun::kill(int signal) const {
  if (pid_ > 0) ::kill(pid_, signal);  // else it has ended
}

bool GuestRun::ended() {
  if (pid_ > 0 && ::waitpid(pid_, &status_, WNOHANG) == pid_) pid_ = -1;
  return pid_ <= 0;
}

void GuestRun::wait() {
  wait_until(path_ + " ends", [this] { return ended(); });
  std::ofstream(path_ + ".code") << (WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_)) << "\n";
}

Showing::Showing(const std::string& device, Signal signal, const ShownFrames& frames, std::uint32_t field, bool yuyv) {
  std::array<int, 2> pipe{};
  if (::pipe(pipe.data()) != 0) throw std::runtime_error("no pipe can be made");
  pid_ = ::fork();
  if (pid_ < 0) throw std::runtime_error("no process can be made");
  if (pid_ == 0) {
    ::close(pipe[0]);
    ready_pipe = pipe[1];
    try {
      show(device, signal, frames, field, yuyv, [] { [[maybe_unused]] const ssize_t n = ::write(ready_pipe, "+", 1); });
    } catch (const std::exception& error) {
      const std::string text = error.what();
      [[maybe_unused]] const ssize_t n = ::write(ready_pipe, text.data(), text.size());
    }
    ::_exit(1);
  }
  ::close(pipe[1]);
  std::array<char, 300> answer{};
  const ssize_t count = ::read(pipe[0], answer.data(), answer.size() - 1);
  ::close(pipe[0]);
  if (count == 1 && answer[0] == '+') return;
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
  throw std::runtime_error(fmt::format("nothing is shown: {}", answer.data()));
}

Showing::~Showing() {
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
}

}  // namespace vsfind::test
