#pragma once
/// @file
/// Reads a named pipe, with pauses: to whoever writes into it, it is a slow disk.

#include <atomic>
#include <functional>
#include <string>
#include <thread>

namespace vsfind::test {

class SlowReader {
 public:
  /// Makes the pipe. Every whole line is handed to `line`, on a thread of its own.
  SlowReader(const std::string& path, std::function<void(const std::string&)> line);
  ~SlowReader();
  SlowReader(const SlowReader&) = delete;
  SlowReader& operator=(const SlowReader&) = delete;

  void pause(bool paused) { paused_ = paused; }
  /// Once the writer has closed the pipe: reads what is left. Returns what follows the last line end.
  [[nodiscard]] std::string finish();

 private:
  void run();

  int file_ = -1;
  std::function<void(const std::string&)> line_;
  std::string rest_;
  std::atomic<bool> paused_ = false;
  std::atomic<bool> ending_ = false;
  std::thread thread_;
};

}  // namespace vsfind::test
