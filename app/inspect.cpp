#include <memory>

#include "acquisition/errors.h"
#include "app/command.h"
#include "app/model_picture.h"
#include "app/model_report.h"
#include "app/output_file.h"
#include "app/program.h"
#include "app/settings.h"
#include "finder/model_file.h"

namespace vsfind {
namespace {

struct InspectRequest {
  std::string model;
  std::string points;
  std::string picture;
};

std::vector<Setting> inspect_settings(InspectRequest& request) {
  InspectRequest* const r = &request;
  using Values = const std::vector<std::string>&;
  Setting model{"model", "MODEL", "File that vsfind train has written", [r](Values v) { r->model = parse_path(v[0]); }};
  model.positional = true;
  return {model,
          {"points", "FILE|-",
           "Write the points as CSV: level,x,y,use,value,gradient_x,gradient_y; x, y are full-resolution pattern "
           "pixels from the origin, value grey levels (of 255), gradients grey levels per pixel",
           [r](Values v) { r->points = parse_path(v[0]); }},
          {"picture", "FILE.png", "Draw the pattern enlarged with its points",
           [r](Values v) { r->picture = parse_path(v[0]); }}};
}

int run_inspect(const InspectRequest& request) {
  if (request.model.empty()) throw UsageError("inspect: a MODEL is needed; see vsfind inspect --help");
  const Pattern pattern = load_model(request.model);
  if (!request.points.empty()) OutputFile(request.points).write(points_csv(pattern));
  if (!request.picture.empty()) write_model_picture(pattern, request.picture);
  if (request.points != "-") {
    std::string text = describe(pattern);
    for (const auto& warning : pattern.report.warnings) text += "warning      " + warning + "\n";
    OutputFile("-").write(text);
  }
  return exit_done;
}

std::function<int()> declare_inspect(CLI::App& app) {
  struct State {
    InspectRequest request;
    Settings settings{inspect_settings(request)};
  };
  auto state = std::make_shared<State>();
  state->settings.declare(app);
  return [state] {
    state->settings.apply_command_line();
    return run_inspect(state->request);
  };
}

}  // namespace

Command inspect_command() {
  return {"inspect", "Show what is in a model file",
          "Example: vsfind inspect part.vsm --points points.csv --picture points.png", declare_inspect};
}

}  // namespace vsfind
