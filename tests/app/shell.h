#pragma once
/// @file
/// Runs the real program and keeps what it says.

#include <sys/types.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace vsfind::test {

struct Outcome {
  int code = -1;    ///< exit code; 128 + signal where a signal ended it
  std::string out;  ///< stdout
  std::string err;  ///< stderr
};

/// A folder that goes with the object.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  [[nodiscard]] std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

/// A started program; its stdout and stderr go to files.
class Process {
 public:
  /// `stdout_file` empty: kept and given by wait().
  explicit Process(const std::vector<std::string>& arguments, const std::string& stdout_file = {});
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  void kill(int signal) const;
  [[nodiscard]] pid_t pid() const { return pid_; }
  [[nodiscard]] Outcome wait();

 private:
  TemporaryFolder folder_;
  pid_t pid_ = -1;
  bool out_kept_;
};

/// vsfind with these arguments, until it ends.
[[nodiscard]] Outcome vsfind(const std::vector<std::string>& arguments, const std::string& stdout_file = {});

[[nodiscard]] std::string read_file(const std::string& path);
void write_file(const std::string& path, const std::string& bytes);
[[nodiscard]] std::vector<std::string> lines_of(const std::string& text);
/// Of one line of a CSV without quoted cells.
[[nodiscard]] std::vector<std::string> csv_cells(const std::string& line);
/// Rows of a CSV (without quoted cells), each by column name.
[[nodiscard]] std::vector<std::map<std::string, std::string>> csv_rows(const std::string& text);

}  // namespace vsfind::test
