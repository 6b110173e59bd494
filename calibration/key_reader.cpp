#include "calibration/key_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "acquisition/errors.h"

namespace vsfind {
namespace {

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0U : 1U);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row.back();
}

void append_numbers(const YamlNode& node, std::vector<double>& numbers, bool& good) {
  if (node.kind == YamlNode::Kind::list) {
    for (const YamlNode& item : node.items) append_numbers(item, numbers, good);
    return;
  }
  const auto number = node.kind == YamlNode::Kind::scalar ? decimal_number(node.text) : std::nullopt;
  good = good && number.has_value();
  numbers.push_back(number.value_or(0.0));
}

}  // namespace

std::optional<double> decimal_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::string nearest_known(std::string_view wanted, const std::vector<std::string>& known) {
  if (wanted.size() > 64) return {};
  std::string best;
  std::size_t best_distance = std::max<std::size_t>(1, wanted.size() / 3) + 1;
  for (const std::string& name : known) {
    const std::size_t distance = edit_distance(wanted, name);
    if (distance >= best_distance) continue;
    best_distance = distance;
    best = name;
  }
  return best.empty() ? best : " (did you mean " + best + "?)";
}

KeyReader::KeyReader(std::string file, const YamlNode& node, std::string path)
    : file_(std::move(file)), node_(&node), path_(std::move(path)) {
  if (node.kind == YamlNode::Kind::map) return;
  const std::string where = path_.empty() ? "" : path_.substr(0, path_.size() - 1) + ": ";
  throw UsageError(fmt::format("{}:{}: {}expected keys and values (`key: value`)", file_, node.line, where));
}

const YamlNode* KeyReader::find(const std::string& key) {
  if (std::find(known_.begin(), known_.end(), key) == known_.end()) known_.push_back(key);
  return node_->find(key);
}

const YamlNode& KeyReader::get(const std::string& key) {
  const YamlNode* node = find(key);
  if (node == nullptr) throw UsageError(fmt::format("{}:{}: {}{}: missing", file_, node_->line, path_, key));
  return *node;
}

std::string KeyReader::text(const std::string& key) {
  const YamlNode& node = get(key);
  if (node.kind != YamlNode::Kind::scalar) fail(key, "must be a word");
  return node.text;
}

double KeyReader::number(const std::string& key) {
  const YamlNode& node = get(key);
  const auto value = node.kind == YamlNode::Kind::scalar ? decimal_number(node.text) : std::nullopt;
  if (!value) fail(key, "must be a number");
  return *value;
}

double KeyReader::number(const std::string& key, double min, double max) {
  const double value = number(key);
  if (!(value >= min && value <= max))
    fail(key, fmt::format("{} is out of range (allowed: {} to {})", value, min, max));
  return value;
}

int KeyReader::whole(const std::string& key, int min, int max) {
  const double value = number(key, min, max);
  if (value != std::floor(value)) fail(key, fmt::format("{} is no whole number", value));
  return static_cast<int>(value);
}

std::vector<double> KeyReader::numbers(const std::string& key, int count) {
  std::vector<double> values;
  const YamlNode& node = get(key);
  bool good = node.kind == YamlNode::Kind::list;
  append_numbers(node, values, good);
  const std::string wanted = count < 0 ? "a list of numbers" : fmt::format("a list of {} numbers", count);
  if (!good) fail(key, "must be " + wanted);
  if (count >= 0 && values.size() != static_cast<std::size_t>(count)) {
    fail(key, fmt::format("has {} numbers, must be {}", values.size(), wanted));
  }
  return values;
}

KeyReader KeyReader::map(const std::string& key) { return KeyReader(file_, get(key), path_ + key + "."); }

void KeyReader::refuse_unknown() const {
  for (std::size_t i = 0; i < node_->keys.size(); ++i) {
    const std::string& key = node_->keys[i];
    if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
    std::string allowed;
    for (const std::string& name : known_) allowed += (allowed.empty() ? "" : ", ") + name;
    throw UsageError(fmt::format("{}:{}: {}{}: unknown key{} (allowed: {})", file_, node_->items[i].line, path_,
                                 shown(key), nearest_known(key, known_), allowed));
  }
}

void KeyReader::fail(const std::string& key, const std::string& what) const {
  const YamlNode* node = node_->find(key);
  throw UsageError(fmt::format("{}:{}: {}{}: {}", file_, node != nullptr ? node->line : node_->line, path_, key, what));
}

}  // namespace vsfind
