#pragma once
/// @file
/// The program from its arguments to its exit code.

#include <exception>
#include <string>
#include <vector>

namespace vsfind {

/// The exit codes that are promised outside.
enum ExitCode : int { exit_done = 0, exit_usage = 2, exit_io = 3, exit_camera = 4 };

/// Runs the command that the arguments (without the program's name) ask for. Never throws.
[[nodiscard]] int run_program(std::vector<std::string> arguments) noexcept;

/// Writes an error as one line on stderr, `vsfind: …`, and returns its exit code.
int report_error(const std::exception_ptr& error) noexcept;

}  // namespace vsfind
