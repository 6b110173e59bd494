#pragma once
/// @file
/// The program under test, run in the guest: as a child of one process that has everything loaded already, because
/// loading takes seconds under emulation. What it says and its exit code go to files that the host reads.

#include <sys/types.h>

#include <string>
#include <vector>

#include "tests/acquisition/vivid/vivid_device.h"

namespace vsfind::test {

/// Calls `condition` until it is true. Throws std::runtime_error with `what` after half a minute.
void wait_until(const std::string& what, bool (*condition)(const void*), const void* state);
template <typename Condition>
void wait_until(const std::string& what, const Condition& condition) {
  wait_until(
      what, [](const void* state) { return (*static_cast<const Condition*>(state))(); }, &condition);
}

/// vsfind with some arguments; stdout, stderr and exit code go to FOLDER/NAME.out, .err and .code.
class GuestRun {
 public:
  GuestRun(const std::string& folder, const std::string& name, const std::vector<std::string>& arguments);
  ~GuestRun();
  GuestRun(const GuestRun&) = delete;
  GuestRun& operator=(const GuestRun&) = delete;

  /// Does nothing once it has ended.
  void kill(int signal) const;
  /// Whether it has ended by itself.
  [[nodiscard]] bool ended();
  /// Waits for its end and writes down its exit code.
  void wait();

 private:
  std::string path_;
  pid_t pid_;
  int status_ = 0;
};

/// Frames shown through vivid's output by a process of its own, from the first frame that was really shown until the
/// object's end.
class Showing {
 public:
  Showing(const std::string& device, Signal signal, const ShownFrames& frames, std::uint32_t field, bool yuyv);
  ~Showing();
  Showing(const Showing&) = delete;
  Showing& operator=(const Showing&) = delete;

 private:
  pid_t pid_;
};

}  // namespace vsfind::test
