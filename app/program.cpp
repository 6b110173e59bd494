#include "app/program.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <map>
#include <new>
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>

#include "acquisition/camera.h"
#include "acquisition/errors.h"
#include "app/command.h"
#include "app/log.h"
#include "app/nearest.h"
#include "app/output_file.h"
#include "app/settings.h"
#include "app/version.h"

namespace vsfind {
namespace {

std::vector<Command> all_commands() {
  std::vector<Command> commands;
#define VSFIND_ADD_COMMAND(name) commands.push_back(name##_command());
  VSFIND_COMMANDS(VSFIND_ADD_COMMAND)
#undef VSFIND_ADD_COMMAND
  return commands;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const auto& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

std::vector<std::string> options_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const auto* option : app.get_options()) {
    for (const auto& name : option->get_lnames()) names.push_back("--" + name);
    for (const auto& name : option->get_snames()) names.push_back("-" + name);
  }
  return names;
}

bool looks_like_a_number(const std::string& text) {
  return text.size() > 1 && text[0] == '-' && (text[1] == '.' || (text[1] >= '0' && text[1] <= '9'));
}

/// Refuses the first unknown option before anything else is complained about, so that a mistyped name is named and
/// not its consequence.
void check_option_names(const CLI::App& app, const std::vector<std::string>& arguments) {
  const auto known = options_of(app);
  for (const auto& argument : arguments) {
    if (argument == "--") return;
    if (argument.size() < 2 || argument[0] != '-' || looks_like_a_number(argument)) continue;
    const std::string name = argument[1] == '-' ? argument.substr(0, argument.find('=')) : argument.substr(0, 2);
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      const bool letter = name.size() == 2;  // any letter is close to any other
      throw UsageError("unknown option " + name + (letter ? std::string{} : did_you_mean(name, known)) + "; see " +
                       (app.get_parent() == nullptr ? "" : "vsfind ") + app.get_name() + " --help");
    }
  }
}

/// Joins an option and the negative value that follows it ("--angle", "-45:45" to "--angle=-45:45"), which would else
/// be read as an option itself.
std::vector<std::string> with_negative_values_joined(const std::vector<std::string>& arguments) {
  std::vector<std::string> joined_arguments;
  bool names_end = false;
  for (const auto& argument : arguments) {
    names_end = names_end || argument == "--";
    if (!names_end && looks_like_a_number(argument) && !joined_arguments.empty() &&
        joined_arguments.back().starts_with("--") && joined_arguments.back().find('=') == std::string::npos) {
      joined_arguments.back() += "=" + argument;
    } else {
      joined_arguments.push_back(argument);
    }
  }
  return joined_arguments;
}

int run(std::vector<std::string> arguments) {
  const auto commands = all_commands();
  CLI::App app{
      "Learns a pattern from one picture and finds it in others, in sub-pixel position, angle and scale.\n"
      "Coordinates: x right, y down, an integer is a pixel centre; positive angles turn +x toward +y.",
      "vsfind"};
  app.set_help_flag("-h,--help", "Print this help");
  app.set_version_flag("--version", std::string("vsfind ") + version_text);
  app.require_subcommand(1, 1);
  app.get_formatter()->column_width(help_name_width);
  app.footer(
      "vsfind COMMAND --help shows a command's options.\n"
      "Exit codes: 0 done (found or not), 2 bad usage, model, calibration or configuration, 3 input or output "
      "failed, 4 camera failed.");
  std::map<const CLI::App*, std::function<int()>> actions;
  std::vector<std::string> names;
  for (const auto& command : commands) {
    auto* sub = app.add_subcommand(command.name, command.description);
    sub->set_help_flag("-h,--help", "Print this help");
    sub->footer(command.footer);
    add_log_options(*sub);
    actions[sub] = command.declare(*sub);
    names.emplace_back(command.name);
  }

  if (arguments.empty()) throw UsageError("a command is needed (allowed: " + joined(names) + "); see vsfind --help");
  if (!arguments[0].starts_with("-")) {
    if (std::find(names.begin(), names.end(), arguments[0]) == names.end()) {
      throw UsageError("unknown command '" + arguments[0] + "'" + did_you_mean(arguments[0], names) +
                       " (allowed: " + joined(names) + ")");
    }
    check_option_names(*app.get_subcommand(arguments[0]), {arguments.begin() + 1, arguments.end()});
  } else {
    check_option_names(app, {arguments[0]});
  }

  arguments = with_negative_values_joined(arguments);
  std::reverse(arguments.begin(), arguments.end());  // CLI11 takes them from the back
  try {
    app.parse(arguments);
  } catch (const CLI::CallForVersion& version) {
    OutputFile("-").write_line(version.what());
    return exit_done;
  } catch (const CLI::CallForHelp&) {
    OutputFile("-").write(app.help());  // of the command, where one was named
    return exit_done;
  } catch (const CLI::ParseError& error) {
    throw UsageError(error.what());
  }
  apply_log_options();
  log_camera_libraries();
  return actions.at(app.get_subcommands().front())();
}

/// One line whatever the text: names of files may hold anything.
std::string one_line(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

}  // namespace

int report_error(const std::exception_ptr& error) noexcept {
  const auto say = [](const std::string& text, int code) {
    fmt::print(stderr, "vsfind: {}\n", one_line(text));
    return code;
  };
  try {
    try {
      std::rethrow_exception(error);
    } catch (const UsageError& e) {
      return say(e.what(), exit_usage);
    } catch (const CameraError& e) {
      return say(e.what(), exit_camera);
    } catch (const IoError& e) {
      return say(e.what(), exit_io);
    } catch (const std::bad_alloc&) {
      return say("out of memory", exit_io);
    } catch (const std::exception& e) {
      return say(std::string("unexpected failure: ") + e.what(), exit_io);
    }
  } catch (...) {
    return exit_io;
  }
}

int run_program(std::vector<std::string> arguments) noexcept {
  try {
    std::signal(SIGPIPE, SIG_IGN);  // a closed pipe is an error of the write to it
    // Messages of the image decoders would be further lines beside ours; threads are ours to start.
    cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
    cv::setNumThreads(1);
    return run(std::move(arguments));
  } catch (...) {
    return report_error(std::current_exception());
  }
}

}  // namespace vsfind
