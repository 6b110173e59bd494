#pragma once
/// @file
/// Reads a map of a YAML file key by key; every complaint names file, line, key and what is allowed. For the files of
/// this folder, not a public door.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/yaml_tree.h"

namespace vsfind {

/// A plain decimal number that is the whole of the text, '.' as the decimal point whatever the locale. Finite, or
/// nothing.
[[nodiscard]] std::optional<double> decimal_number(std::string_view text);

/// The known name nearest to `wanted` as " (did you mean NAME?)", or "".
[[nodiscard]] std::string nearest_known(std::string_view wanted, const std::vector<std::string>& known);

class KeyReader {
 public:
  /// `path` is what stands before the keys in complaints: "" or "lens.". The node must outlive the reader. Throws
  /// UsageError unless the node is a map.
  KeyReader(std::string file, const YamlNode& node, std::string path = "");

  /// The value of a key, or nullptr. A key that is asked for is a known one.
  [[nodiscard]] const YamlNode* find(const std::string& key);
  [[nodiscard]] bool has(const std::string& key) { return find(key) != nullptr; }
  /// The same, but the key must be there.
  [[nodiscard]] const YamlNode& get(const std::string& key);

  [[nodiscard]] std::string text(const std::string& key);
  [[nodiscard]] double number(const std::string& key);
  [[nodiscard]] double number(const std::string& key, double min, double max);
  [[nodiscard]] int whole(const std::string& key, int min, int max);
  /// A list of numbers; `count` of them where it is not negative. Lists in the list are joined, row after row.
  [[nodiscard]] std::vector<double> numbers(const std::string& key, int count = -1);
  [[nodiscard]] KeyReader map(const std::string& key);

  /// Refuses the first key that nobody asked for, naming the nearest known one.
  void refuse_unknown() const;

  /// `file:line: key: what`.
  [[noreturn]] void fail(const std::string& key, const std::string& what) const;

 private:
  std::string file_;
  const YamlNode* node_;
  std::string path_;
  std::vector<std::string> known_;
};

}  // namespace vsfind
