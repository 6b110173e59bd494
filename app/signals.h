#pragma once
/// @file
/// SIGINT and SIGTERM as a polite request to end.

#include <functional>
#include <memory>
#include <thread>

namespace vsfind {

/// While it lives, the first SIGINT or SIGTERM calls `on_signal` (on a thread of its own), a second one ends the
/// process at once. Make it before other threads are started, so that they leave the signals to it.
class SignalWatcher {
 public:
  explicit SignalWatcher(std::function<void()> on_signal);
  /// Ends the watch; the signals mean what they meant before.
  ~SignalWatcher();
  SignalWatcher(const SignalWatcher&) = delete;
  SignalWatcher& operator=(const SignalWatcher&) = delete;

 private:
  struct State;
  std::unique_ptr<State> state_;
  std::thread thread_;
};

}  // namespace vsfind
