#include <CLI/CLI.hpp>
#include <memory>

#include "acquisition/errors.h"
#include "acquisition/source.h"
#include "app/command.h"
#include "app/config.h"
#include "app/frame_searcher.h"
#include "app/pipeline.h"
#include "app/program.h"
#include "app/replay_options.h"
#include "app/result_output.h"
#include "app/source_mapping.h"

namespace vsfind {
namespace {

int run_replay(ReplayRequest& request) {
  RunOptions& options = request.options;
  if (request.source.empty()) throw UsageError("replay: a SEQUENCE is needed, here or as source in the configuration");
  complete_run_options(options);
  SignalWatcher signals;  // before the threads of the source and the search
  const auto patterns = load_models(options.models);
  const auto source = open_sequence(request.source);
  check_region(options.search, source->info().width, source->info().height, request.source);
  FrameSearcher searcher(patterns, options, mapping_for(request.source, source->info().pixel_aspect, options.mapping));
  ResultOutput output(options, source->info().frames);
  const std::exception_ptr error = run_pipeline(*source, searcher, output, signals);
  output.clear_progress();
  const int code = error ? report_error(error) : exit_done;
  output.finish();
  return code;
}

std::function<int()> declare_replay(CLI::App& app) {
  struct State {
    ReplayRequest request;
    Settings settings{replay_settings(request)};
  };
  auto state = std::make_shared<State>();
  state->settings.declare(app);
  app.add_option("--config", state->request.config,
                 "Take settings from a YAML file: options' names with _ for -, and source; its paths are\n"
                 "relative to its folder; what the command line says goes before it")
      ->type_name("FILE");
  return [state] {
    if (!state->request.config.empty()) apply_config(load_config(state->request.config), state->settings.all());
    state->settings.apply_command_line();
    return run_replay(state->request);
  };
}

}  // namespace

Command replay_command() {
  return {"replay", "Find trained patterns in every frame of a recording",
          "Rows: source is the sequence's path, frame the source's own counter (a gap is a lost frame); instance\n"
          "counts from 0, best first; a frame that is damaged gives a row bad_frame per model. x, y are calibrated\n"
          "coordinates (pixels, x times the pixel aspect), image_x, image_y frame pixels, angles degrees from +x\n"
          "toward +y, times milliseconds. SIGINT and SIGTERM finish the frame in hand.\n"
          "Example: vsfind replay line.y4m --model part.vsm --field split --csv rows.csv --overlay pictures",
          declare_replay};
}

}  // namespace vsfind
