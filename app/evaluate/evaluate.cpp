#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "acquisition/errors.h"
#include "acquisition/source.h"
#include "app/command.h"
#include "app/evaluate/evaluation.h"
#include "app/evaluate/truth_file.h"
#include "app/frame_searcher.h"
#include "app/output_file.h"
#include "app/program.h"
#include "app/signals.h"

namespace vsfind {
namespace {

struct EvaluateRequest {
  std::string source;
  std::string truth;
  Tolerance tolerance;
  bool instances_given = false;
  RunOptions options;  ///< csv: the judgements
};

std::vector<Setting> evaluate_settings(EvaluateRequest& request) {
  EvaluateRequest* const r = &request;
  using Values = const std::vector<std::string>&;
  Setting source{"source", "SEQUENCE", "Recording (.y4m), or folder of images in name order",
                 [r](Values v) { r->source = parse_path(v[0]); }};
  source.positional = true;
  std::vector<Setting> settings{source};
  settings.push_back(
      {"truth", "FILE.csv", "What is to be found (needed), see below", [r](Values v) { r->truth = parse_path(v[0]); }});
  settings.push_back({"max-error", "D",
                      "How far from its true place a match is still right, px or the calibration's "
                      "unit (default 2)",
                      [r](Values v) { r->tolerance.position = parse_number(v[0], 0.0, 1e9); }});
  settings.push_back({"max-angle-error", "DEG", "The same for the angle, degrees, where the truth has one (default 2)",
                      [r](Values v) { r->tolerance.angle_deg = parse_number(v[0], 0.0, 360.0); }});
  for (auto& setting : run_settings(request.options,
                                    "What is searched of every frame, and what the truth is of: frame, "
                                    "top, bottom, or split: both fields (default frame)")) {
    if (setting.name == "jsonl" || setting.name == "overlay") continue;
    if (setting.name == "csv")
      setting.help = "Write every judgement as CSV; - is stdout, and the summary is then left out";
    if (setting.name == "report") {
      setting.help =
          "Write report.html (complete in itself) and its charts into this folder: errors over the frames, "
          "the worst cases as pictures";
    }
    if (setting.name == "max-instances") {
      setting.help = "At most so many of each pattern in a picture; 0: all (default: as many as the truth has in one)";
      setting.set = [r](Values v) {
        r->options.search.max_instances = parse_whole(v[0], 0, 1000000);
        r->instances_given = true;
      };
    }
    settings.push_back(std::move(setting));
  }
  return settings;
}

int run_evaluate(EvaluateRequest& request) {
  RunOptions& options = request.options;
  if (request.source.empty()) throw UsageError("evaluate: a SEQUENCE is needed; see vsfind evaluate --help");
  if (request.truth.empty()) throw UsageError("--truth is needed: a CSV file with frame, x, y, and more");
  if (options.models.empty()) throw UsageError("--model is needed: a file that vsfind train has written");
  SignalWatcher signals;  // before any other thread
  const auto patterns = load_models(options.models);
  Evaluation evaluation(load_truth(request.truth), request.tolerance, patterns);
  if (!request.instances_given) options.search.max_instances = evaluation.most_instances();
  const auto source = open_sequence(request.source);
  check_region(options.search, source->info().width, source->info().height, request.source);
  FrameSearcher searcher(patterns, options, mapping_for(request.source, source->info().pixel_aspect, options.mapping));
  signals.on_signal([&source] { source->stop(); });
  // What came before a damaged end is judged all the same.
  std::exception_ptr error;
  try {
    while (const auto frame = source->next()) {
      const FrameResult result = searcher.search(request.source, frame->info(), frame->image());
      evaluation.add(result, *result.mapping);
    }
  } catch (...) {
    error = std::current_exception();
  }
  signals.on_signal({});
  if (!options.csv.empty()) evaluation.write_csv(options.csv);
  if (!options.report.empty()) {
    std::string models;
    for (const auto& model : options.models) models += (models.empty() ? "" : ", ") + model;
    evaluation.write_report(
        options.report,
        {{"sequence", request.source},
         {"truth", request.truth},
         {"models", models},
         {"searched", name(options.field)},
         {"weakest score", fmt::format("{:g}", options.search.min_score)},
         {"instances at most", fmt::format("{}", options.search.max_instances)},
         {"right within", fmt::format("{:g}, {:g} degrees", request.tolerance.position, request.tolerance.angle_deg)},
         {"calibration", options.mapping.calibration.empty() ? "none" : options.mapping.calibration}});
  }
  if (options.csv != "-") OutputFile("-").write(evaluation.text());
  return error ? report_error(error) : exit_done;
}

std::function<int()> declare_evaluate(CLI::App& app) {
  struct State {
    EvaluateRequest request;
    Settings settings{evaluate_settings(request)};
  };
  auto state = std::make_shared<State>();
  state->settings.declare(app);
  return [state] {
    state->settings.apply_command_line();
    return run_evaluate(state->request);
  };
}

}  // namespace

Command evaluate_command() {
  return {"evaluate", "Compare what is found in a sequence with known or hand-marked poses",
          "The truth is CSV with a header. Columns: frame (the source's counter); x, y (calibrated coordinates) or\n"
          "image_x, image_y (frame pixels); optional field (frame, top, bottom; left out: any), model, angle_deg,\n"
          "scale_x, scale_y, status (found, not_found). A line without a position says that nothing is there; a frame\n"
          "without a line is not judged. Other columns are passed over: rows that vsfind has written will do.\n"
          "Lengths in px or the calibration's unit, angles in degrees, times in milliseconds.\n"
          "Example: vsfind evaluate line.y4m --truth marked.csv --model part.vsm --field split --report judged",
          declare_evaluate};
}

}  // namespace vsfind
