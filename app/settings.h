#pragma once
/// @file
/// One list of settings behind both the command line and the configuration file: `--min-score` here is `min_score:`
/// there. A setting turns text into a member of an options struct.

#include <functional>
#include <string>
#include <vector>

#include "app/values.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace vsfind {

struct Setting {
  std::string name;   ///< as an option without its dashes: "min-score"
  std::string value;  ///< what its value looks like, for the help: "MIN:MAX"; empty for a switch
  std::string help;
  /// Takes all values that one layer (command line or file) gives, at least one; throws ValueError.
  std::function<void(const std::vector<std::string>&)> set;

  char letter = '\0';                   ///< a one-letter form, "-o"
  bool repeatable = false;              ///< may be given several times
  bool path = false;                    ///< in a configuration: relative to its folder
  bool uri = false;                     ///< like path, for a `file:` URI
  bool positional = false;              ///< on the command line without a name, shown as `value`
  bool pairs = false;                   ///< NAME=VALUE: in a configuration also a mapping of names to values
  char separator = '\0';                ///< in a configuration, a list is the same as its items joined by this
  std::vector<std::string> excludes{};  ///< settings that cannot be given beside it in the same layer
};

class Settings {
 public:
  explicit Settings(std::vector<Setting> settings) : settings_(std::move(settings)) {}

  /// Makes an option of every setting. `app` must outlive this object's use.
  void declare(CLI::App& app);

  /// Sets what the parsed command line gives. Throws UsageError naming the option.
  void apply_command_line() const { apply_command_line(settings_); }

  /// The same into other targets: the same settings, bound to something else.
  void apply_command_line(const std::vector<Setting>& targets) const;

  /// Whether the parsed command line gives a setting.
  [[nodiscard]] bool is_given(const std::string& name) const;

  [[nodiscard]] const std::vector<Setting>& all() const { return settings_; }

 private:
  std::vector<Setting> settings_;
  std::vector<CLI::Option*> options_;
};

/// The help of a command: option names to the left of this column, texts of this width to the right of it.
inline constexpr std::size_t help_name_width = 32;
inline constexpr std::size_t help_text_width = 86;

/// The same name as a configuration's key: "min_score".
[[nodiscard]] std::string key_of(const Setting& setting);

}  // namespace vsfind
