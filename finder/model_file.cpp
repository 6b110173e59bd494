#include "finder/model_file.h"

#include <fmt/format.h>
#include <zlib.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "acquisition/errors.h"
#include "finder/coarse_search.h"

namespace vsfind {

namespace {

using Json = nlohmann::ordered_json;

constexpr const char* format_name = "vsfind-model";
constexpr int format_version = 1;
constexpr std::uintmax_t largest_file = 256U << 20U;
constexpr int longest_side = 16384;
constexpr std::size_t most_points = 200000;
constexpr int deepest_level = 12;

/// Of the pattern's text: tells a damaged or hand-edited file from a whole one.
std::string checksum(const Json& pattern) {
  const std::string text = pattern.dump();
  const uLong crc = crc32_z(crc32_z(0, nullptr, 0), reinterpret_cast<const Bytef*>(text.data()), text.size());
  return fmt::format("{:08x}", crc);
}

Json json_of(const Range& range) { return Json::array({range.min, range.max}); }

Json json_of(const PointSet& set) {
  Json points = Json::array();
  for (const PatternPoint& p : set.points) {
    points.push_back(Json::array({p.x, p.y, p.value, p.gradient_x, p.gradient_y, p.laplacian}));
  }
  return {{"level", set.level}, {"use", name(set.use)}, {"points", std::move(points)}};
}

Json json_of(const Pattern& p) {
  Json sets = Json::array();
  for (const PointSet& set : p.sets) sets.push_back(json_of(set));
  return {{"name", p.name},
          {"unit", p.unit},
          {"pitch", p.pitch},
          {"pixel_aspect", p.pixel_aspect},
          {"from_field", p.from_field},
          {"width", p.width},
          {"height", p.height},
          {"left", p.left},
          {"top", p.top},
          {"angle_deg", json_of(p.angle_deg)},
          {"scale_x", json_of(p.scale_x)},
          {"scale_y", json_of(p.scale_y)},
          {"common_scale", p.common_scale},
          {"accuracy", p.accuracy},
          {"edges", p.edges},
          {"edge_threshold", p.edge_threshold},
          {"spread", p.spread},
          {"polarity", name(p.polarity)},
          {"top_level", p.top_level},
          {"angle_step_deg", p.angle_step_deg},
          {"scale_step", p.scale_step},
          {"report",
           {{"training_ms", p.report.training_ms},
            {"impostor_score", p.report.impostor_score},
            {"impostor", p.report.impostor},
            {"noise_sigma", p.report.noise_sigma},
            {"sigma_x", p.report.sigma_x},
            {"sigma_y", p.report.sigma_y},
            {"sigma_angle_deg", p.report.sigma_angle_deg},
            {"warnings", p.report.warnings}}},
          {"sets", std::move(sets)},
          {"image",
           {{"width", p.image.width},
            {"height", p.image.height},
            {"origin_x", p.image.origin_x},
            {"origin_y", p.image.origin_y},
            {"grey", p.image.grey},
            {"mask", p.image.mask}}}};
}

/// Reads values by key, complaining with file, key and allowed values.
class ModelReader {
 public:
  ModelReader(const Json& json, const std::string& path, std::string prefix = "")
      : json_(json), path_(path), prefix_(std::move(prefix)) {}

  [[noreturn]] void fail(const std::string& key, const std::string& why) const {
    throw UsageError(fmt::format("{}: key '{}{}' {}", path_, prefix_, key, why));
  }
  [[nodiscard]] const Json& at(const std::string& key) const {
    if (!json_.is_object() || !json_.contains(key)) fail(key, "is missing");
    return json_.at(key);
  }
  [[nodiscard]] bool has(const std::string& key) const { return json_.is_object() && json_.contains(key); }
  [[nodiscard]] double number(const std::string& key, double least, double most) const {
    const Json& value = at(key);
    if (!value.is_number()) fail(key, "is not a number");
    const auto number = value.get<double>();
    if (!(number >= least && number <= most)) {
      fail(key, fmt::format("is {} (allowed: {} to {})", number, least, most));
    }
    return number;
  }
  [[nodiscard]] int integer(const std::string& key, int least, int most) const {
    if (!at(key).is_number_integer()) fail(key, "is not a whole number");
    return static_cast<int>(number(key, least, most));
  }
  [[nodiscard]] bool flag(const std::string& key) const {
    if (!at(key).is_boolean()) fail(key, "is neither true nor false");
    return at(key).get<bool>();
  }
  [[nodiscard]] std::string text(const std::string& key) const {
    if (!at(key).is_string()) fail(key, "is not a text");
    return at(key).get<std::string>();
  }
  [[nodiscard]] Range range(const std::string& key, double least, double most) const {
    const Json& value = at(key);
    if (!value.is_array() || value.size() != 2 || !value[0].is_number() || !value[1].is_number()) {
      fail(key, "is not a range [min, max]");
    }
    const Range range{value[0].get<double>(), value[1].get<double>()};
    if (!(range.min <= range.max && range.min >= least && range.max <= most)) {
      fail(key, fmt::format("is {}:{} (allowed: min <= max within {}:{})", range.min, range.max, least, most));
    }
    return range;
  }
  [[nodiscard]] ModelReader inside(const std::string& key) const { return {at(key), path_, prefix_ + key + "."}; }
  template <typename Value>
  [[nodiscard]] std::vector<Value> numbers(const std::string& key, std::size_t count, int most) const {
    const Json& value = at(key);
    if (!value.is_array() || value.size() != count) fail(key, fmt::format("is not a list of {} numbers", count));
    std::vector<Value> out;
    out.reserve(count);
    for (const Json& each : value) {
      if (!each.is_number_integer() || each.get<std::int64_t>() < 0 || each.get<std::int64_t>() > most) {
        fail(key, fmt::format("holds something else than whole numbers from 0 to {}", most));
      }
      out.push_back(static_cast<Value>(each.get<std::int64_t>()));
    }
    return out;
  }

 private:
  const Json& json_;
  const std::string& path_;
  std::string prefix_;
};

PointUse use_from(const ModelReader& reader) {
  const std::string text = reader.text("use");
  for (const PointUse use :
       {PointUse::search, PointUse::follow, PointUse::refine, PointUse::outline, PointUse::verify}) {
    if (text == name(use)) return use;
  }
  reader.fail("use", fmt::format("is '{}' (allowed: search, follow, refine, outline, verify)", text));
}

PointSet set_from(const ModelReader& reader) {
  PointSet set;
  set.level = reader.integer("level", 0, deepest_level);
  set.use = use_from(reader);
  const Json& points = reader.at("points");
  const bool searched = set.use == PointUse::search;
  const std::size_t most = searched ? static_cast<std::size_t>(most_coarse_points) : most_points;
  if (!points.is_array() || points.size() > most || (searched && (points.size() % 2 != 0 || points.size() < 4))) {
    reader.fail("points",
                fmt::format("is not a list of at most {} points{}", most, searched ? ", an even number" : ""));
  }
  for (const Json& each : points) {
    if (!each.is_array() || each.size() != 6) reader.fail("points", "holds something else than lists of 6 numbers");
    double v[6];
    for (std::size_t i = 0; i < 6; ++i) {
      constexpr double largest = 1e6;
      if (!each[i].is_number() || !(std::abs(each[i].get<double>()) <= largest)) {
        reader.fail("points", fmt::format("holds something else than numbers up to {}", largest));
      }
      v[i] = each[i].get<double>();
    }
    set.points.push_back({v[0], v[1], static_cast<float>(v[2]), static_cast<float>(v[3]), static_cast<float>(v[4]),
                          static_cast<float>(v[5])});
  }
  return set;
}

Polarity polarity_from(const ModelReader& reader) {
  const std::string text = reader.text("polarity");
  for (const Polarity polarity : {Polarity::same, Polarity::reversed, Polarity::any}) {
    if (text == name(polarity)) return polarity;
  }
  reader.fail("polarity", fmt::format("is '{}' (allowed: same, reversed, any)", text));
}

Pattern pattern_from(const Json& json, const std::string& path) {
  const ModelReader r(json, path, "pattern.");
  Pattern p;
  constexpr double far = 1e9;
  p.name = r.text("name");
  p.unit = r.text("unit");
  p.pitch = r.number("pitch", 1e-9, far);
  p.pixel_aspect = r.number("pixel_aspect", 0.01, 100.0);
  p.width = r.number("width", 1.0, longest_side);
  p.height = r.number("height", 1.0, longest_side);
  p.left = r.number("left", -1e6, 1e6);
  p.top = r.number("top", -1e6, 1e6);
  p.angle_deg = r.range("angle_deg", -360.0, 360.0);
  p.scale_x = r.range("scale_x", 0.5, 2.0);
  p.scale_y = r.range("scale_y", 0.5, 2.0);
  p.common_scale = r.flag("common_scale");
  p.accuracy = r.integer("accuracy", 1, 100);
  p.edges = r.flag("edges");
  p.edge_threshold = r.number("edge_threshold", p.edges ? least_edge_threshold : 0.0, 255.0);
  p.spread = r.flag("spread");
  if (r.has("from_field")) p.from_field = r.flag("from_field");  // earlier models lack it
  p.polarity = polarity_from(r);
  p.top_level = r.integer("top_level", 0, deepest_level);
  p.angle_step_deg = r.number("angle_step_deg", 0.0, 180.0);
  p.scale_step = r.number("scale_step", 0.0, 4.0);
  // A step that is far too fine would make the search try without end.
  if (p.angle_deg.searched() && p.angle_step_deg < 0.05)
    r.fail("angle_step_deg", "is too fine (allowed: 0.05 or more)");
  if ((p.scale_x.searched() || p.scale_y.searched()) && p.scale_step < 0.005) {
    r.fail("scale_step", "is too fine (allowed: 0.005 or more)");
  }
  const GridSize grid = size_of({p.angle_deg, p.scale_x, p.scale_y, p.common_scale, p.angle_step_deg, p.scale_step});
  if (grid.hypotheses() > static_cast<double>(most_hypotheses)) {
    r.fail(
        "angle_step_deg",
        fmt::format("and the others of the coarse search ask for {:.0f} turned and scaled copies (allowed: up to {})",
                    grid.hypotheses(), most_hypotheses));
  }
  const ModelReader report = r.inside("report");
  p.report.training_ms = report.number("training_ms", 0.0, far);
  p.report.impostor_score = report.number("impostor_score", -1.0, 1.01);
  if (report.has("impostor")) p.report.impostor = report.text("impostor");  // earlier models lack it
  p.report.noise_sigma = report.number("noise_sigma", 0.0, far);
  p.report.sigma_x = report.number("sigma_x", 0.0, far);
  p.report.sigma_y = report.number("sigma_y", 0.0, far);
  p.report.sigma_angle_deg = report.number("sigma_angle_deg", 0.0, far);
  const Json& warnings = report.at("warnings");
  if (!warnings.is_array()) report.fail("warnings", "is not a list of texts");
  for (const Json& each : warnings) {
    if (!each.is_string()) report.fail("warnings", "is not a list of texts");
    p.report.warnings.push_back(each.get<std::string>());
  }
  const Json& sets = r.at("sets");
  if (!sets.is_array() || sets.size() > 64) r.fail("sets", "is not a list of at most 64 point sets");
  bool searched = false;
  bool refined = false;
  bool verified = false;
  for (const Json& each : sets) {
    p.sets.push_back(set_from(ModelReader(each, path, "pattern.sets.")));
    const PointSet& set = p.sets.back();
    searched = searched || (set.use == PointUse::search && set.level == p.top_level);
    refined = refined || set.use == PointUse::refine;
    verified = verified || set.use == PointUse::verify;
  }
  if (!searched || !refined || !verified) r.fail("sets", "lacks the points of search, refine or verify");
  const ModelReader image = r.inside("image");
  p.image.width = image.integer("width", 1, longest_side);
  p.image.height = image.integer("height", 1, longest_side);
  p.image.origin_x = image.number("origin_x", -1e6, 1e6);
  p.image.origin_y = image.number("origin_y", -1e6, 1e6);
  const auto size = static_cast<std::size_t>(p.image.width) * static_cast<std::size_t>(p.image.height);
  p.image.grey = image.numbers<std::uint16_t>("grey", size, 65535);
  p.image.mask = image.numbers<std::uint8_t>("mask", size, 255);
  return p;
}

/// The whole of a file that may be a pipe or a device, which tell no size.
std::string read_bounded(std::ifstream& in, const std::string& path) {
  std::string text;
  std::string block(std::size_t{1} << 16U, '\0');
  while (in.read(block.data(), static_cast<std::streamsize>(block.size())), in.gcount() > 0) {
    text.append(block, 0, static_cast<std::size_t>(in.gcount()));
    if (text.size() > largest_file) {
      throw UsageError(fmt::format("{}: is no model: it has more than the {} bytes allowed", path, largest_file));
    }
  }
  return text;
}

/// Whether brackets nest deeper than in any model: what follows recurses into them.
bool nests_too_deeply(const std::string& text) {
  constexpr int deepest = 32;
  int depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted && c == '\\') {
      ++i;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (!quoted && (c == '[' || c == '{')) {
      if (++depth > deepest) return true;
    } else if (!quoted && (c == ']' || c == '}')) {
      --depth;
    }
  }
  return false;
}

}  // namespace

void save_model(const Pattern& pattern, const std::string& path) {
  Json body = json_of(pattern);
  const std::string sum = checksum(body);
  const Json file = {
      {"format", format_name}, {"version", format_version}, {"checksum", sum}, {"pattern", std::move(body)}};
  // Beside the target, then renamed: a reader never sees half a model.
  const std::string beside = path + ".part";
  {
    std::ofstream out(beside, std::ios::binary | std::ios::trunc);
    out << file.dump() << '\n';
    out.flush();
    if (!out) {
      std::error_code ignored;
      std::filesystem::remove(beside, ignored);
      throw IoError(fmt::format("{}: cannot write the model", path));
    }
  }
  std::error_code failed;
  std::filesystem::rename(beside, path, failed);
  if (failed) {
    std::error_code ignored;
    std::filesystem::remove(beside, ignored);
    throw IoError(fmt::format("{}: cannot write the model: {}", path, failed.message()));
  }
}

Pattern load_model(const std::string& path) {
  std::error_code failed;
  const auto status = std::filesystem::status(path, failed);
  if (!std::filesystem::exists(status)) throw IoError(fmt::format("{}: no such model file", path));
  if (std::filesystem::is_directory(status)) throw IoError(fmt::format("{}: is a folder, not a model file", path));
  std::ifstream in(path, std::ios::binary);
  if (!in) throw IoError(fmt::format("{}: cannot read the model", path));
  const std::uintmax_t size = std::filesystem::file_size(path, failed);
  if (!failed && size > largest_file) {
    throw UsageError(fmt::format("{}: is no model: it has {} bytes (allowed: at most {})", path, size, largest_file));
  }
  const std::string text = read_bounded(in, path);
  const Json file = nests_too_deeply(text) ? Json() : Json::parse(text, nullptr, false);
  if (file.is_discarded() || !file.is_object() || !file.contains("format") || file.at("format") != format_name) {
    throw UsageError(fmt::format("{}: is no vsfind model, or damaged", path));
  }
  const ModelReader reader(file, path);
  const int version = reader.integer("version", 1, 1000000);
  if (version > format_version) {
    reader.fail("version", fmt::format("is {}: made by a newer vsfind (allowed: up to {})", version, format_version));
  }
  const std::string sum = reader.text("checksum");
  const Json& body = reader.at("pattern");
  Pattern pattern = pattern_from(body, path);
  if (sum != checksum(body)) reader.fail("checksum", "does not fit the content: the file is damaged or was edited");
  return pattern;
}

}  // namespace vsfind
