#include "app/settings.h"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "acquisition/errors.h"

namespace vsfind {

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
          setting.name, [](const CLI::results_t&) { return true; }, setting.help);
      option->type_name(setting.value);
      if (setting.repeatable) option->expected(1, CLI::detail::expected_max_vector_size);
      options_.push_back(option);
      continue;
    }
    std::string names = "--" + setting.name;
    if (setting.letter != '\0') names = std::string("-") + setting.letter + "," + names;
    if (setting.value.empty()) {
      options_.push_back(app.add_flag(names, setting.help));
      continue;
    }
    auto* option = app.add_option(
        names, [](const CLI::results_t&) { return true; }, setting.help);
    option->type_name(setting.value)->allow_extra_args(false)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    options_.push_back(option);
  }
}

void Settings::apply_command_line() const {
  const auto shown = [](const Setting& setting) { return setting.positional ? setting.value : "--" + setting.name; };
  const auto given = [this](const std::string& name) {
    for (std::size_t i = 0; i < settings_.size(); ++i) {
      if (settings_[i].name == name) return options_[i]->count() > 0;
    }
    return false;
  };
  for (std::size_t i = 0; i < options_.size(); ++i) {
    const Setting& setting = settings_[i];
    if (options_[i]->count() == 0) continue;
    for (const auto& other : setting.excludes) {
      if (given(other)) throw UsageError(shown(setting) + " and --" + other + " cannot be given together");
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
