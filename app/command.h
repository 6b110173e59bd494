#pragma once
/// @file
/// What a subcommand is. A new one is a file that defines `Command NAME_command()`, and its name in the list below.

#include <functional>

namespace CLI {
class App;
}

namespace vsfind {

struct Command {
  const char* name;
  const char* description;  ///< one line for the list of commands
  const char* footer;       ///< below the options in its help: conventions and an example
  /// Declares the options on the subcommand's own `app` and returns what to do once they are parsed: does the work
  /// and returns the exit code, or throws UsageError, IoError or CameraError.
  std::function<int()> (*declare)(CLI::App& app);
};

// The list of commands, in the order of the help.
#define VSFIND_COMMANDS(X) \
  X(train)                 \
  X(find)                  \
  X(replay)                \
  X(live)                  \
  X(record)                \
  X(cameras)               \
  X(inspect)               \
  X(calibrate)             \
  X(qualify)               \
  X(evaluate)

#define VSFIND_DECLARE_COMMAND(name) [[nodiscard]] Command name##_command();
VSFIND_COMMANDS(VSFIND_DECLARE_COMMAND)
#undef VSFIND_DECLARE_COMMAND

}  // namespace vsfind
