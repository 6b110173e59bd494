#include "app/settings.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <sstream>

#include "acquisition/errors.h"

namespace vsfind {

namespace {

/// Help in lines that fit beside the options' names.
std::string wrapped(const std::string& help) {
  std::string text;
  std::string word;
  std::size_t column = 0;
  std::istringstream words(help);
  while (words >> word) {
    if (column > 0 && column + 1 + word.size() > help_text_width) {
      text += '\n';
      column = 0;
    }
    if (column > 0) {
      text += ' ';
      ++column;
    }
    text += word;
    column += word.size();
  }
  return text;
}

}  // namespace

std::string key_of(const Setting& setting) {
  std::string key = setting.name;
  std::replace(key.begin(), key.end(), '-', '_');
  return key;
}

void Settings::declare(CLI::App& app) {
  options_.clear();
  for (const auto& setting : settings_) {
    if (setting.positional) {
      // The callback does nothing: values are read from the option once all of the command line is known to parse.
      auto* option = app.add_option(
          setting.value, [](const CLI::results_t&) { return true; }, wrapped(setting.help));
      option->type_name("");
      if (setting.repeatable) option->expected(-1)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
      options_.push_back(option);
      continue;
    }
    std::string names;
    if (setting.letter != '\0') names = {'-', setting.letter, ','};
    names += "--" + setting.name;
    if (setting.value.empty()) {
      const std::string help = wrapped(setting.help);
      options_.push_back(app.add_flag(names, help));
      continue;
    }
    auto* option = app.add_option(
        names, [](const CLI::results_t&) { return true; }, wrapped(setting.help));
    option->type_name(setting.value)->allow_extra_args(false)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    options_.push_back(option);
  }
}

bool Settings::is_given(const std::string& name) const {
  for (std::size_t i = 0; i < settings_.size(); ++i) {
    if (settings_[i].name == name) return options_[i]->count() > 0;
  }
  return false;
}

void Settings::apply_command_line(const std::vector<Setting>& targets) const {
  const auto shown = [](const Setting& setting) { return setting.positional ? setting.value : "--" + setting.name; };
  for (std::size_t i = 0; i < options_.size(); ++i) {
    const Setting& setting = targets[i];
    if (options_[i]->count() == 0) continue;
    for (const auto& other : setting.excludes) {
      if (is_given(other)) throw UsageError(shown(setting) + " and --" + other + " cannot be given together");
    }
    auto values = options_[i]->results();
    if (setting.value.empty()) values.assign(1, "true");
    if (values.size() > 1 && !setting.repeatable) throw UsageError(shown(setting) + " is given more than once");
    try {
      setting.set(values);
    } catch (const ValueError& error) {
      throw UsageError(shown(setting) + " " + error.what());
    }
  }
}

}  // namespace vsfind
