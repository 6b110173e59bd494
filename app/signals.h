#pragma once
/// @file
/// SIGINT and SIGTERM as a polite request to end.

#include <functional>
#include <memory>
#include <thread>

namespace vsfind {

/// While it lives, the first SIGINT or SIGTERM calls a function (on a thread of its own), a second one ends the
/// process at once. Make it before any other thread is started: threads made later leave the signals to it.
class SignalWatcher {
 public:
  SignalWatcher();
  /// Ends the watch; the signals mean what they meant before.
  ~SignalWatcher();
  SignalWatcher(const SignalWatcher&) = delete;
  SignalWatcher& operator=(const SignalWatcher&) = delete;

  /// What the first signal does; called at once where one came already. Replaces what was set before, and returns
  /// when that is no longer running. An empty function: nothing.
  void on_signal(std::function<void()> action);

 private:
  struct State;
  std::unique_ptr<State> state_;
  std::thread thread_;
};

}  // namespace vsfind
