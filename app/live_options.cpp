#include "app/live_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <set>

#include "acquisition/errors.h"
#include "app/camera_options.h"

namespace vsfind {
namespace {

constexpr double longest_s = 1e9;

bool is_of_output(const Setting& setting) {
  return setting.name == "csv" || setting.name == "jsonl" || setting.name == "overlay" || setting.name == "report";
}

std::vector<Setting> search_settings(LiveSource& source) {
  return run_settings(
      source.options,
      "What is searched of every frame: frame: all lines; top, bottom: that field only; split: both "
      "fields, the earlier one first, a row each. Frames that come as single fields are searched as such "
      "(default frame)");
}

/// What each source may have of its own.
std::vector<Setting> source_settings(LiveSource& source) {
  LiveSource* const s = &source;
  std::vector<Setting> settings;
  for (auto& setting : search_settings(source)) {
    if (!is_of_output(setting)) settings.push_back(std::move(setting));
  }
  for (auto& setting : camera_settings(source.camera)) settings.push_back(std::move(setting));
  settings.push_back({"record", "FILE.y4m", "Record what is searched, losslessly; a replay of it gives the same rows",
                      [s](const std::vector<std::string>& v) { s->record = parse_path(v[0]); }});
  settings.back().path = true;
  return settings;
}

std::uint64_t parse_size(const std::string& text) {
  constexpr std::array<std::pair<const char*, double>, 4> units{{{"kB", 1e3}, {"MB", 1e6}, {"GB", 1e9}, {"B", 1.0}}};
  for (const auto& [unit, factor] : units) {
    if (!text.ends_with(unit)) continue;
    const std::string number = text.substr(0, text.size() - std::string(unit).size());
    return static_cast<std::uint64_t>(parse_number(number, 1.0, 1e6) * factor);
  }
  throw ValueError("'" + text + "' is not known (allowed: day, or a size such as 100MB, with kB, MB or GB)");
}

Setting source_setting(std::function<void(const std::vector<std::string>&)> set) {
  Setting setting{"source", "URI",
                  "Camera or recording: v4l2:/dev/videoN, gige:NAME-OR-ADDRESS, gige: (the first one), file:SEQUENCE "
                  "(needed; repeatable: all are searched at once)",
                  std::move(set)};
  setting.uri = true;
  return setting;
}

void check_together(const std::vector<LiveSource>& sources) {
  std::set<std::string> uris;
  std::set<std::string> records;
  for (const auto& source : sources) {
    if (!uris.insert(source.uri).second)
      throw UsageError(fmt::format("--source {} is given twice: its rows could not be told apart", source.uri));
    if (!source.record.empty() && !records.insert(source.record).second)
      throw UsageError(
          fmt::format("--record {} is given for two sources (allowed: a file for each, in sources: of a "
                      "configuration)",
                      source.record));
  }
}

}  // namespace

std::vector<Setting> live_settings(LiveRequest& request) {
  LiveRequest* const r = &request;
  using Values = const std::vector<std::string>&;
  std::vector<Setting> settings;
  const auto add = [&settings](std::string name, std::string value, std::string help, auto set) -> Setting& {
    return settings.emplace_back(Setting{std::move(name), std::move(value), std::move(help), std::move(set)});
  };
  settings.push_back(source_setting([r](Values values) {
    r->uris.clear();
    for (const auto& value : values) r->uris.push_back(value);
  }));
  settings.back().repeatable = true;
  for (auto& setting : source_settings(request.common)) settings.push_back(std::move(setting));
  for (auto& setting : search_settings(request.common)) {
    if (is_of_output(setting)) settings.push_back(std::move(setting));
  }
  add("rotate", "day|SIZE",
      "Begin a new file of rows every midnight, or before it grows beyond SIZE: 100MB (repeatable)",
      [r](Values values) {
        r->row_files.daily = false;
        r->row_files.max_bytes = 0;
        for (const auto& value : values) {
          if (value == "day") {
            r->row_files.daily = true;
          } else {
            r->row_files.max_bytes = parse_size(value);
          }
        }
      })
      .repeatable = true;
  add("rotate-keep", "N",
      "Keep the N newest of the files of rows that were rotated away, remove older ones (default: all)", [r](Values v) {
        r->row_files.keep = static_cast<std::size_t>(parse_whole(v[0], 1, std::numeric_limits<int>::max()));
      });
  add("frames", "N", "End after N frames of each source",
      [r](Values v) { r->frames = static_cast<std::uint64_t>(parse_whole(v[0], 1, std::numeric_limits<int>::max())); });
  add("seconds", "S", "End after S seconds", [r](Values v) { r->seconds = parse_number(v[0], 0.001, longest_s); });
  add("give-up-after", "S", "End, with exit code 4, when a camera has been gone for S seconds (default: never)",
      [r](Values v) { r->give_up_after = parse_number(v[0], 0.0, longest_s); });
  return settings;
}

void apply_live_config(LiveRequest& request, const std::vector<Setting>& settings) {
  Config config = load_config(request.config);
  const std::optional<ConfigEntry> sources = config.take("sources");
  apply_config(config, settings);
  if (!sources) return;
  const std::string where = fmt::format("{}:{}: key sources", config.path, sources->line);
  if (sources->blocks.empty())
    throw UsageError(where + ": is not a list of sources (allowed: items with source: URI and settings)");
  if (!request.uris.empty()) throw UsageError(where + ": cannot be given together with source");
  for (const auto& block : sources->blocks) {
    LiveSource source = request.common;
    auto known = source_settings(source);
    known.insert(known.begin(), source_setting([&source](const std::vector<std::string>& v) { source.uri = v[0]; }));
    apply_config({config.path, block}, known);
    if (source.uri.empty()) throw UsageError(where + ": an item has no source (allowed: source: URI)");
    request.sources.push_back(std::move(source));
  }
}

void complete_live_request(LiveRequest& request, const Settings& settings) {
  if (!request.config.empty()) apply_live_config(request, settings.all());
  if (!request.sources.empty() && settings.is_given("source"))
    throw UsageError("--source cannot be given together with sources: of " + request.config);
  settings.apply_command_line();
  // What the command line says goes before what a source's own part of the configuration says.
  for (auto& source : request.sources) {
    LiveRequest one;
    one.common = std::move(source);
    settings.apply_command_line(live_settings(one));
    source = std::move(one.common);
    source.options.csv = request.common.options.csv;
    source.options.jsonl = request.common.options.jsonl;
    source.options.overlay = request.common.options.overlay;
    source.options.report = request.common.options.report;
  }
  for (const auto& uri : request.uris) {
    request.sources.push_back(request.common);
    request.sources.back().uri = uri;
  }
  if (request.sources.empty())
    throw UsageError("live: --source URI is needed, here or as source in the configuration; see vsfind live --help");
  for (auto& source : request.sources) {
    static_cast<void>(parse_source_uri(source.uri));
    complete_run_options(source.options);
  }
  check_together(request.sources);
  if (request.row_files.keep > 0 && !request.row_files.rotates())
    throw UsageError("--rotate-keep is of no use without --rotate (allowed with it: day, or a size such as 100MB)");
  request.row_files.keep_going = true;
}

}  // namespace vsfind
