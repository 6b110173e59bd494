#include "app/run_options.h"

#include <limits>

#include "acquisition/errors.h"

namespace vsfind {

std::vector<Setting> run_settings(RunOptions& options, const std::string& field_help) {
  RunOptions* const o = &options;
  using Values = const std::vector<std::string>&;
  std::vector<Setting> settings;
  const auto add = [&settings](std::string name, std::string value, std::string help, auto set) -> Setting& {
    return settings.emplace_back(Setting{std::move(name), std::move(value), std::move(help), std::move(set)});
  };

  auto& model = add("model", "FILE", "Trained pattern to look for (needed; repeatable)", [o](Values values) {
    o->models.clear();
    for (const auto& value : values) o->models.push_back(parse_path(value));
  });
  model.repeatable = true;
  model.path = true;

  add("min-score", "0..1", "Weakest correlation that is reported (default 0.65)",
      [o](Values v) { o->search.min_score = parse_number(v[0], 0.0, 1.0); });
  add("coarse-score", "0..1",
      "Coarse acceptance: candidates of the exhaustive search that correlate less are not followed; higher is faster, "
      "lower misses less where much is hidden (default: half of --min-score)",
      [o](Values v) { o->search.coarse_score = parse_number(v[0], 0.0, 1.0); });
  add("max-instances", "N", "At most so many of each pattern in a picture; 0: all, 200 at the most (default 1)",
      [o](Values v) { o->search.max_instances = parse_whole(v[0], 0, std::numeric_limits<int>::max()); });
  add("max-overlap", "0..1", "Part of the smaller outline that two instances may share (default 0.5)",
      [o](Values v) { o->search.max_overlap = parse_number(v[0], 0.0, 1.0); });
  add("region", "X,Y,W,H", "Where the origin is looked for, frame pixels (default: everywhere)", [o](Values v) {
    o->search.region = parse_roi(v[0]);
  }).separator = ',';
  add("angle", "MIN:MAX", "Angles searched, degrees, within those trained for (default: those)", [o](Values v) {
    o->search.angle_deg = parse_range(v[0], -360.0, 360.0, "degrees");
  }).separator = ':';
  auto& scale = add("scale", "MIN:MAX", "Scales searched, both axes alike, within those trained for",
                    [o](Values v) { o->search.scale_x = o->search.scale_y = parse_range(v[0], 0.5, 2.0, ""); });
  scale.separator = ':';
  scale.excludes = {"scale-x", "scale-y"};
  add("scale-x", "MIN:MAX", "Scales searched along the pattern's x, within those trained for", [o](Values v) {
    o->search.scale_x = parse_range(v[0], 0.5, 2.0, "");
  }).separator = ':';
  add("scale-y", "MIN:MAX", "Scales searched along the pattern's y, within those trained for", [o](Values v) {
    o->search.scale_y = parse_range(v[0], 0.5, 2.0, "");
  }).separator = ':';
  auto& calibration =
      add("calibration", "FILE", "Calibration of the camera: x, y are then in its unit, on its plane", [o](Values v) {
        o->mapping = {parse_path(v[0]), std::nullopt};
      });
  calibration.path = true;
  calibration.excludes = {"pixel-aspect"};
  auto& aspect = add("pixel-aspect", "W:H",
                     "Pixel width to height of a whole frame; also pal (59:54) or ntsc (10:11) (default: what the "
                     "recording says, else 1:1)",
                     [o](Values v) {
                       o->mapping = {{}, parse_pixel_aspect(v[0])};
                     });
  aspect.separator = ':';

  add("field", "frame|top|bottom|split", field_help, [o](Values v) {
    o->field = parse_word<FieldMode>(v[0], {{"frame", FieldMode::frame},
                                            {"top", FieldMode::top},
                                            {"bottom", FieldMode::bottom},
                                            {"split", FieldMode::split}});
  });
  add("csv", "FILE|-", "Write rows as CSV; - is stdout (the default without --jsonl)", [o](Values v) {
    o->csv = parse_path(v[0]);
  }).path = true;
  add("jsonl", "FILE|-", "Write rows as JSON Lines; - is stdout", [o](Values v) { o->jsonl = parse_path(v[0]); }).path =
      true;
  add("overlay", "DIR", "Write a PNG of every searched picture with what was found drawn into it", [o](Values v) {
    o->overlay = parse_path(v[0]);
  }).path = true;
  add("report", "DIR",
      "Write report.html (complete in itself) and its charts into this folder: score and pose over time, times, "
      "failures",
      [o](Values v) { o->report = parse_path(v[0]); })
      .path = true;
  add("timeout-ms", "T",
      "Longest time for a search of a picture, milliseconds; what is found by then is reported, with timed_out 1; "
      "0: none (default 0)",
      [o](Values v) { o->search.timeout_ms = parse_number(v[0], 0.0, 1e9); });
  add("threads", "N", "Threads of a search, 1 to 64; rows do not depend on it (default 1)",
      [o](Values v) { o->search.threads = parse_whole(v[0], 1, 64); });
  return settings;
}

void complete_run_options(RunOptions& options) {
  if (options.models.empty()) throw UsageError("--model is needed: a file that vsfind train has written");
  if (options.csv.empty() && options.jsonl.empty()) options.csv = "-";
  if (options.csv == options.jsonl) {
    throw UsageError("--csv and --jsonl cannot both go to " + (options.csv == "-" ? "stdout" : options.csv));
  }
}

}  // namespace vsfind
