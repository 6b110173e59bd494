#include "calibration/yaml_tree.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <set>
#include <system_error>

#include "acquisition/errors.h"

namespace vsfind {
namespace {

constexpr int deepest = 32;
constexpr int most_nodes = 400000;
constexpr std::size_t largest_file = 16U << 20U;

class Converter {
 public:
  explicit Converter(const std::string& file) : file_(file) {}

  // An alias is followed as often as it stands there, so nodes are counted as they come.
  YamlNode convert(const YAML::Node& from, int depth) {
    YamlNode node;
    node.line = from.Mark().line + 1;
    if (depth > deepest || ++nodes_ > most_nodes) {
      throw UsageError(
          fmt::format("{}:{}: nested deeper than {} or more than {} values", file_, node.line, deepest, most_nodes));
    }
    switch (from.Type()) {
      case YAML::NodeType::Scalar:
        node.kind = YamlNode::Kind::scalar;
        node.text = from.Scalar();
        break;
      case YAML::NodeType::Sequence:
        node.kind = YamlNode::Kind::list;
        for (const auto& item : from) node.items.push_back(convert(item, depth + 1));
        break;
      case YAML::NodeType::Map:
        node.kind = YamlNode::Kind::map;
        convert_entries(from, depth, node);
        break;
      case YAML::NodeType::Null:
      case YAML::NodeType::Undefined:
        break;
    }
    return node;
  }

 private:
  void convert_entries(const YAML::Node& from, int depth, YamlNode& node) {
    std::set<std::string> seen;
    for (const auto& entry : from) {
      const int line = entry.first.Mark().line + 1;
      if (!entry.first.IsScalar()) throw UsageError(fmt::format("{}:{}: a key must be a word", file_, line));
      const std::string key = entry.first.Scalar();
      if (!seen.insert(key).second) throw UsageError(fmt::format("{}:{}: {}: given twice", file_, line, shown(key)));
      node.keys.push_back(key);
      YamlNode& item = node.items.emplace_back(convert(entry.second, depth + 1));
      // Blocks begin below their key, and a value left empty has no place of its own: the key's line is the one to look
      // at.
      if (item.kind != YamlNode::Kind::scalar) item.line = line;
    }
  }

  const std::string& file_;
  int nodes_ = 0;
};

}  // namespace

const YamlNode* YamlNode::find(const std::string& key) const {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i] == key) return &items[i];
  }
  return nullptr;
}

YamlNode parse_yaml(const std::string& text, const std::string& file) {
  std::string standard = text;
  // OpenCV's own spelling of the directive, which is no YAML, becomes a comment.
  if (standard.starts_with("%YAML:")) standard[0] = '#';
  try {
    return Converter(file).convert(YAML::Load(standard), 0);
  } catch (const YAML::Exception& error) {
    throw UsageError(fmt::format("{}:{}: no valid YAML: {}", file, error.mark.line + 1, shown(error.msg)));
  }
}

std::string shown(std::string_view text) {
  std::string result(text.substr(0, 64));
  for (char& c : result) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  }
  return result;
}

std::string read_small_file(const std::string& path) {
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  const auto failed = [&path] {
    const int reason = errno != 0 ? errno : EIO;
    return IoError(fmt::format("{}: cannot be read: {}", path, std::generic_category().message(reason)));
  };
  if (!stream) throw failed();
  std::string text;
  char block[4096];
  while (stream.read(block, sizeof block) || stream.gcount() > 0) {
    text.append(block, static_cast<std::size_t>(stream.gcount()));
    if (text.size() > largest_file) throw UsageError(path + ": too large for a calibration (allowed: up to 16 MB)");
  }
  if (stream.bad()) throw failed();
  return text;
}

}  // namespace vsfind
