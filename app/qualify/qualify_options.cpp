#include "app/qualify/qualify_options.h"

#include <limits>

#include "acquisition/errors.h"
#include "app/camera_options.h"

namespace vsfind {
namespace {

constexpr std::size_t most_fiducials = 64;
constexpr std::size_t most_accuracies = 20;

void set_fiducials(FiducialChoice& choice, const std::vector<std::string>& values) {
  choice = {};
  for (const auto& value : values) {
    if (value != "auto" && value != "none") {
      choice.regions.push_back(parse_roi(value));
      continue;
    }
    if (values.size() > 1) throw ValueError("'" + value + "' stands alone (allowed: auto, none, or X,Y,W,H repeated)");
    choice.wanted = value == "auto";
  }
  if (choice.wanted && choice.regions.size() == 1) {
    throw ValueError("one region alone tells no angle (allowed: 2 to 64 regions, each with one square)");
  }
  if (choice.regions.size() > most_fiducials) throw ValueError("too many regions (allowed: 2 to 64)");
}

void set_steps(StepChoice& choice, const std::string& value) {
  choice.kind = StepChoice::Kind::interval;
  if (value == "every") choice.kind = StepChoice::Kind::every;
  if (value == "enter") choice.kind = StepChoice::Kind::line;
  if (choice.kind != StepChoice::Kind::interval) return;
  try {
    choice.interval_s = parse_number(value, 1e-3, 1e5);
  } catch (const ValueError&) {
    throw ValueError("'" + value + "' is not known (allowed: every, enter, or seconds from 0.001 to 100000)");
  }
}

}  // namespace

bool is_camera(const std::string& source) { return source.starts_with("v4l2:") || source.starts_with("gige:"); }

std::vector<int> parse_accuracies(const std::string& text) {
  std::vector<int> accuracies;
  for (std::size_t begin = 0;;) {
    const std::size_t comma = text.find(',', begin);
    accuracies.push_back(parse_whole(text.substr(begin, comma == std::string::npos ? comma : comma - begin), 1, 100));
    if (accuracies.size() > most_accuracies)
      throw ValueError("too many numbers (allowed: up to 20, with commas between)");
    if (comma == std::string::npos) return accuracies;
    begin = comma + 1;
  }
}

std::vector<Setting> qualify_settings(QualifyRequest& request) {
  QualifyRequest* const r = &request;
  using Values = const std::vector<std::string>&;
  std::vector<Setting> settings;
  const auto add = [&settings](std::string name, std::string value, std::string help, auto set) -> Setting& {
    return settings.emplace_back(Setting{std::move(name), std::move(value), std::move(help), std::move(set)});
  };
  const auto recorded = [r](const char* option, auto set) {
    return [r, option, set](Values v) {
      r->only_recorded.emplace_back(option);
      set(v);
    };
  };
  const auto simulated = [r](const char* option, auto set) {
    return [r, option, set](Values v) {
      r->only_simulated.emplace_back(option);
      set(v);
    };
  };

  add("source", "SEQUENCE",
      "Recording (.y4m), or folder of images in name order, a picture a step; or a camera: v4l2:/dev/videoN, "
      "gige:NAME-OR-ADDRESS, gige: (the first one)",
      recorded("SEQUENCE", [r](Values v) { r->source = parse_path(v[0]); }))
      .positional = true;
  add("model", "FILE", "Trained pattern (needed without --simulate; repeatable: a row of the table each)",
      recorded("--model",
               [r](Values values) {
                 for (const auto& value : values) r->models.push_back(parse_path(value));
               }))
      .repeatable = true;
  add("stage", "linear|rotary",
      "How the target moves: along a straight line, or turning, in equal steps (default linear)",
      recorded("--stage", [r](Values v) {
        r->stage = parse_word<StageKind>(v[0], {{"linear", StageKind::linear}, {"rotary", StageKind::rotary}});
      }));
  add("fiducials", "auto|none|X,Y,W,H",
      "Squares to measure against: the four around the pattern, none, or a region with one square in the first frame, "
      "pixels (repeatable, 2 or more; default auto)",
      [r](Values v) { set_fiducials(r->fiducials, v); })
      .repeatable = true;
  add("angle", "MIN:MAX", "Angles searched, degrees, within those trained for (default: those)",
      recorded("--angle", [r](Values v) { r->search.angle_deg = parse_range(v[0], -360.0, 360.0, "degrees"); }));
  add("region", "X,Y,W,H", "Where the origin is looked for, frame pixels (default: everywhere)",
      recorded("--region", [r](Values v) { r->search.region = parse_roi(v[0]); }));
  add("min-score", "0..1", "Weakest correlation that counts as found (default 0.65)",
      [r](Values v) { r->search.min_score = parse_number(v[0], 0.0, 1.0); });
  add("calibration", "FILE", "Calibration of the camera: results are then in its unit",
      recorded("--calibration",
               [r](Values v) {
                 r->mapping = {parse_path(v[0]), std::nullopt};
               }))
      .excludes = {"pixel-aspect"};
  add("pixel-aspect", "W:H", "Pixel width to height of a whole frame; also pal or ntsc (default: as the source says)",
      recorded("--pixel-aspect", [r](Values v) {
        r->mapping = {{}, parse_pixel_aspect(v[0])};
      }));
  add("field", "frame|top|bottom", "Which lines of each frame are looked at (default frame)",
      recorded("--field", [r](Values v) {
        r->field = parse_word<Field>(v[0], {{"frame", Field::frame}, {"top", Field::top}, {"bottom", Field::bottom}});
      }));
  add("frames", "N", "Stop after so many good frames (needed of a camera)", recorded("--frames", [r](Values v) {
        r->most_frames = static_cast<std::size_t>(parse_whole(v[0], 3, std::numeric_limits<int>::max()));
      }));
  add("take", "every|enter|S",
      "Of a camera: every frame is a step (the stage triggers the camera); or one frame is, for each Enter at stdin, "
      "or "
      "every S seconds (default every)",
      [r](Values v) {
        r->only_live.emplace_back("--take");
        set_steps(r->steps, v[0]);
      });
  for (Setting& setting : camera_settings(r->camera)) {
    setting.set = [r, option = "--" + setting.name, set = std::move(setting.set)](Values v) {
      r->only_live.push_back(option);
      set(v);
    };
    settings.push_back(std::move(setting));
  }
  add("threads", "N", "Threads of a search, 1 to 64 (default 1)",
      [r](Values v) { r->search.threads = parse_whole(v[0], 1, 64); });
  add("report", "DIR", "Write report.html (complete in itself), its charts as PNG, and measured.csv into this folder",
      [r](Values v) { r->report = parse_path(v[0]); });
  add("simulate", "",
      "Render the whole experiment instead: 20 pictures in steps of 1/3 px, and 20 in steps of 0.42 degrees",
      [r](Values v) { r->simulate = parse_switch(v[0]); });
  add("accuracy", "N,N,...", "With --simulate: train at these accuracies, a row of the table each (default 10,20,30)",
      simulated("--accuracy", [r](Values v) { r->accuracies = parse_accuracies(v[0]); }));
  add("noise", "S", "With --simulate: noise, grey levels, 0.3 to 50 (default 2)",
      simulated("--noise", [r](Values v) { r->simulation.noise = parse_number(v[0], 0.3, 50.0); }));
  add("blur", "S", "With --simulate: sigma of the optics, pixels, 0 to 5 (default 0.7)",
      simulated("--blur", [r](Values v) { r->simulation.blur = parse_number(v[0], 0.0, 5.0); }));
  add("steps", "N", "With --simulate: pictures of each test, 3 to 20 (default 20)",
      simulated("--steps", [r](Values v) { r->simulation.steps = parse_whole(v[0], 3, 20); }));
  add("seed", "N", "With --simulate: seed of the noise (default 1)", simulated("--seed", [r](Values v) {
        r->simulation.seed = static_cast<std::uint64_t>(parse_whole(v[0], 0, std::numeric_limits<int>::max()));
      }));
  add("images", "DIR", "With --simulate: write the pictures as recordings, with their truth, into this folder",
      simulated("--images", [r](Values v) { r->images = parse_path(v[0]); }));
  return settings;
}

void complete_qualify_request(const QualifyRequest& request) {
  if (request.simulate) {
    for (const auto* options : {&request.only_recorded, &request.only_live}) {
      if (!options->empty()) throw UsageError(options->front() + " and --simulate cannot be given together");
    }
    return;
  }
  if (!request.only_simulated.empty()) {
    throw UsageError(request.only_simulated.front() + " needs --simulate, as it says what is rendered and trained");
  }
  if (request.source.empty())
    throw UsageError("qualify: a SEQUENCE or --simulate is needed; see vsfind qualify --help");
  if (is_camera(request.source)) {
    if (request.most_frames == 0) {
      throw UsageError(request.source + ": --frames is needed of a camera: the number of steps, 3 or more");
    }
  } else if (!request.only_live.empty()) {
    throw UsageError(request.only_live.front() +
                     " needs a camera as SEQUENCE (allowed: v4l2:/dev/videoN, "
                     "gige:NAME-OR-ADDRESS, gige:)");
  }
  if (request.models.empty()) throw UsageError("--model is needed: a file that vsfind train has written");
}

}  // namespace vsfind
