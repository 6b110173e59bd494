#pragma once
/// @file
/// The log: lines on stderr through spdlog. Warnings by default, more with --verbose, only errors with --quiet.

namespace CLI {
class App;
}

namespace vsfind {

/// Adds `-v,--verbose` and `-q,--quiet` to a command.
void add_log_options(CLI::App& app);
/// Sets the level that the parsed command line asks for.
void apply_log_options();
/// Whether --quiet was given: no progress, no summary.
[[nodiscard]] bool log_is_quiet();

}  // namespace vsfind
