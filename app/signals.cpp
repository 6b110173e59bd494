#include "app/signals.h"

#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <mutex>
#include <string>
#include <utility>

#include "acquisition/errors.h"

namespace vsfind {

struct SignalWatcher::State {
  std::mutex mutex;  // of the two below, held while the action runs
  std::function<void()> action;
  bool signalled = false;
  sigset_t before{};
  int signals = -1;
  int end = -1;

  ~State() {
    if (signals >= 0) ::close(signals);
    if (end >= 0) ::close(end);
    ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
  }

  void watch() {
    bool seen = false;
    for (;;) {
      std::array<pollfd, 2> waited{pollfd{signals, POLLIN, 0}, pollfd{end, POLLIN, 0}};
      if (::poll(waited.data(), waited.size(), -1) < 0 && errno != EINTR) return;
      if ((waited[1].revents & POLLIN) != 0) return;
      if ((waited[0].revents & POLLIN) == 0) continue;
      signalfd_siginfo info{};
      if (::read(signals, &info, sizeof info) != sizeof info) continue;
      constexpr int killed_by = 128;  // a shell's exit code for a process that a signal ended
      if (std::exchange(seen, true)) ::_exit(killed_by + static_cast<int>(info.ssi_signo));
      const std::lock_guard lock(mutex);
      signalled = true;
      if (action) action();
    }
  }
};

SignalWatcher::SignalWatcher() : state_(std::make_unique<State>()) {
  sigset_t wanted;
  sigemptyset(&wanted);
  sigaddset(&wanted, SIGINT);
  sigaddset(&wanted, SIGTERM);
  ::pthread_sigmask(SIG_BLOCK, &wanted, &state_->before);
  state_->signals = ::signalfd(-1, &wanted, SFD_CLOEXEC);
  state_->end = ::eventfd(0, EFD_CLOEXEC);
  if (state_->signals < 0 || state_->end < 0) {
    throw IoError(std::string("signals cannot be watched: ") + std::strerror(errno));
  }
  thread_ = std::thread([state = state_.get()] { state->watch(); });
}

SignalWatcher::~SignalWatcher() {
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = ::write(state_->end, &one, sizeof one);
  thread_.join();
}

void SignalWatcher::on_signal(std::function<void()> action) {
  const std::lock_guard lock(state_->mutex);
  state_->action = std::move(action);
  if (state_->signalled && state_->action) state_->action();
}

}  // namespace vsfind
