#include "app/config.h"

#include <fmt/format.h>
#include <yaml-cpp/depthguard.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "acquisition/errors.h"
#include "app/nearest.h"

namespace vsfind {
namespace {

constexpr std::size_t max_bytes = 1'000'000;
constexpr int max_nesting = 32;  // ours needs two; a parser that recurses is not to be fed more

std::string read_text(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) throw IoError(path + ": is a folder (allowed: a YAML file)");
  std::ifstream file(path, std::ios::binary);
  if (!file) throw IoError(path + ": cannot be read: " + std::strerror(errno));
  std::string text(max_bytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad()) throw IoError(path + ": cannot be read: " + std::strerror(errno));
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() > max_bytes) throw UsageError(path + ": is larger than a configuration may be (allowed: 1 MB)");
  return text;
}

/// Refuses nesting that only an attacker writes, before the parser sees it. Counts brackets and, per line, the
/// characters that open blocks, wherever they stand: too high a count costs nothing at this limit.
void check_nesting(const std::string& path, const std::string& text) {
  int line = 1;
  int brackets = 0;
  int openers = 0;
  for (const char c : text) {
    if (c == '\0') throw UsageError(fmt::format("{}:{}: holds a zero byte (allowed: YAML text)", path, line));
    if (c == '\n') {
      ++line;
      openers = 0;
    }
    if (c == '[' || c == '{') ++brackets;
    if (c == ']' || c == '}') brackets = std::max(0, brackets - 1);
    if (c == '-' || c == '?' || c == ':') ++openers;
    constexpr int max_openers = 256;  // a line of text may hold a rule of dashes
    if (brackets > max_nesting || openers > max_openers) {
      throw UsageError(fmt::format("{}:{}: is nested too deeply (allowed: keys with values or lists)", path, line));
    }
  }
}

/// Takes a document's events and does nothing.
class Ignore final : public YAML::EventHandler {
 public:
  void OnDocumentStart(const YAML::Mark& /*mark*/) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& /*mark*/, YAML::anchor_t /*anchor*/) override {}
  void OnAlias(const YAML::Mark& /*mark*/, YAML::anchor_t /*anchor*/) override {}
  void OnScalar(const YAML::Mark& /*mark*/, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                const std::string& /*value*/) override {}
  void OnSequenceStart(const YAML::Mark& /*mark*/, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                       YAML::EmitterStyle::value /*style*/) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark& /*mark*/, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                  YAML::EmitterStyle::value /*style*/) override {}
  void OnMapEnd() override {}
};

/// Whether more than one document stands there. Looks for a second one only: of some broken texts the parser finds
/// documents without end.
bool holds_several_documents(const std::string& text) {
  std::istringstream in(text);
  YAML::Parser parser(in);
  Ignore ignore;
  return parser.HandleNextDocument(ignore) && parser.HandleNextDocument(ignore);
}

int line_of(const YAML::Node& node) { return node.Mark().line + 1; }

std::string scalar_of(const YAML::Node& node, const std::string& where) {
  if (!node.IsScalar() || node.Scalar().empty()) throw UsageError(where + ": needs a value");
  return node.Scalar();
}

std::vector<ConfigEntry> entries_of(const std::string& path, const YAML::Node& map, int depth);

ConfigEntry entry_of(const std::string& path, const YAML::Node& key, const YAML::Node& value, int depth) {
  if (!key.IsScalar() || key.Scalar().find('\n') != std::string::npos) {
    throw UsageError(fmt::format("{}:{}: a key is not a plain word (allowed: KEY: VALUE)", path, line_of(key)));
  }
  ConfigEntry entry{key.Scalar(), line_of(key), value.IsSequence(), {}};
  const std::string where = fmt::format("{}:{}: key {}", path, entry.line, entry.key);
  if (value.IsMap()) {
    entry.list = true;
    for (const auto& pair : value) {
      if (!pair.first.IsScalar() || pair.second.IsMap() || pair.second.IsSequence())
        throw UsageError(where + ": holds more than names and plain values");
      entry.values.push_back(pair.first.Scalar() + "=" + scalar_of(pair.second, where));
    }
    entry.pairs = true;
    if (entry.values.empty()) throw UsageError(where + ": needs a value");
    return entry;
  }
  if (entry.list && depth == 0 && value.size() > 0 && value[0].IsMap()) {
    for (const auto& item : value) {
      if (!item.IsMap()) throw UsageError(where + ": the list holds plain values and keys alike");
      entry.blocks.push_back(entries_of(path, item, depth + 1));
    }
    return entry;
  }
  if (!entry.list) {
    entry.values.push_back(scalar_of(value, where));
    return entry;
  }
  for (const auto& item : value) {
    if (item.IsMap() || item.IsSequence()) throw UsageError(where + ": the list holds more than plain values");
    entry.values.push_back(scalar_of(item, where));
  }
  if (entry.values.empty()) throw UsageError(where + ": the list is empty");
  return entry;
}

std::vector<ConfigEntry> entries_of(const std::string& path, const YAML::Node& map, int depth) {
  std::vector<ConfigEntry> entries;
  std::map<std::string, int> lines;
  for (const auto& pair : map) {
    ConfigEntry entry = entry_of(path, pair.first, pair.second, depth);
    const auto [earlier, fresh] = lines.emplace(entry.key, entry.line);
    if (!fresh) {
      throw UsageError(fmt::format("{}:{}: key {}: stands in line {} already (allowed: once)", path, entry.line,
                                   entry.key, earlier->second));
    }
    entries.push_back(std::move(entry));
  }
  return entries;
}

/// A path of the configuration as seen from where the program runs.
std::string from_folder_of(const std::string& config_path, const std::string& value) {
  if (value == "-" || value.empty()) return value;
  const std::filesystem::path path(value);
  if (path.is_absolute()) return value;
  return (std::filesystem::path(config_path).parent_path() / path).string();
}

}  // namespace

Config load_config(const std::string& path) {
  const std::string text = read_text(path);
  check_nesting(path, text);
  Config config{path, {}};
  try {
    if (holds_several_documents(text)) {
      throw UsageError(path + ": holds more than one YAML document (allowed: one)");
    }
    const YAML::Node root = YAML::Load(text);
    if (!root || root.IsNull()) return config;
    if (!root.IsMap()) {
      throw UsageError(fmt::format("{}:{}: is not a list of keys (allowed: KEY: VALUE)", path, line_of(root)));
    }
    config.entries = entries_of(path, root, 0);
  } catch (const YAML::DeepRecursion& error) {
    throw UsageError(
        fmt::format("{}:{}: is nested too deeply (allowed: keys with values or lists)", path, error.mark.line + 1));
  } catch (const YAML::Exception& error) {
    throw UsageError(fmt::format("{}:{}: is not YAML: {}", path, error.mark.line + 1, error.msg));
  }
  return config;
}

std::optional<ConfigEntry> Config::take(const std::string& key) {
  const auto place = std::find_if(entries.begin(), entries.end(), [&](const auto& entry) { return entry.key == key; });
  if (place == entries.end()) return std::nullopt;
  ConfigEntry entry = std::move(*place);
  entries.erase(place);
  return entry;
}

void apply_config(const Config& config, const std::vector<Setting>& settings) {
  std::vector<std::string> known;
  known.reserve(settings.size());
  for (const auto& setting : settings) known.push_back(key_of(setting));
  const auto has_key = [&](const std::string& name) {
    return std::any_of(config.entries.begin(), config.entries.end(), [&](const ConfigEntry& entry) {
      return std::any_of(settings.begin(), settings.end(),
                         [&](const Setting& setting) { return setting.name == name && key_of(setting) == entry.key; });
    });
  };
  for (const auto& entry : config.entries) {
    const std::string where = fmt::format("{}:{}: key {}", config.path, entry.line, entry.key);
    const auto setting = std::find_if(settings.begin(), settings.end(),
                                      [&](const Setting& candidate) { return key_of(candidate) == entry.key; });
    if (setting == settings.end()) {
      throw UsageError(fmt::format("{} is not known{} (allowed: {})", where, did_you_mean(entry.key, known),
                                   fmt::join(known, ", ")));
    }
    for (const auto& other : setting->excludes) {
      if (has_key(other)) throw UsageError(fmt::format("{}: cannot be given together with {}", where, other));
    }
    if (!entry.blocks.empty() || (entry.pairs && !setting->pairs))
      throw UsageError(where + ": holds keys of its own (allowed: a value or a list)");
    std::vector<std::string> values = entry.values;
    if (entry.list && !setting->repeatable) {
      if (setting->separator == '\0')
        throw UsageError(where + ": is a list (allowed: one value, " + setting->value + ")");
      std::string joined;
      for (const auto& value : values) {
        if (!joined.empty()) joined += setting->separator;
        joined += value;
      }
      values.assign(1, joined);
    }
    if (setting->uri) {
      const std::string file = "file:";
      for (auto& value : values) {
        if (value.starts_with(file))
          value.replace(file.size(), std::string::npos, from_folder_of(config.path, value.substr(file.size())));
      }
    }
    if (setting->path) {
      for (auto& value : values) value = from_folder_of(config.path, value);
    }
    try {
      setting->set(values);
    } catch (const ValueError& error) {
      throw UsageError(where + ": " + error.what());
    }
  }
}

}  // namespace vsfind
