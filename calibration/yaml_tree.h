#pragma once
/// @file
/// A small YAML file as a plain tree, with the lines for complaints. Reads standard YAML and the dialect that OpenCV's
/// FileStorage writes (`%YAML:1.0`, `!!opencv-matrix`). For the files of this folder, not a public door.

#include <string>
#include <string_view>
#include <vector>

namespace vsfind {

/// One node: a scalar's text, or the items of a list or a map in the order of the file.
struct YamlNode {
  enum class Kind { null, scalar, list, map };
  Kind kind = Kind::null;
  int line = 1;  ///< counted from 1
  std::string text;
  std::vector<YamlNode> items;
  std::vector<std::string> keys;  ///< of a map: one per item

  /// The item of a map under this key, or nullptr.
  [[nodiscard]] const YamlNode* find(const std::string& key) const;
};

/// The first document of the text. `file` is named in complaints. Throws UsageError where it is no YAML, where a key
/// stands twice, and where it nests deeper than 32 or holds more than 400000 nodes.
[[nodiscard]] YamlNode parse_yaml(const std::string& text, const std::string& file);

/// Foreign text for a complaint: at most 64 bytes, control characters as '?', so that it stays on its line.
[[nodiscard]] std::string shown(std::string_view text);

/// The whole of a file of at most 16 MB. Throws IoError where it cannot be read, UsageError where it is too large.
[[nodiscard]] std::string read_small_file(const std::string& path);

}  // namespace vsfind
