#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <sstream>

#include "acquisition/errors.h"
#include "app/command.h"
#include "app/log.h"
#include "app/output_file.h"
#include "app/program.h"
#include "app/qualify/qualify_options.h"
#include "app/qualify/qualify_report.h"
#include "app/qualify/simulation.h"
#include "app/result_row.h"
#include "app/signals.h"
#include "app/source_events.h"
#include "finder/train.h"

namespace vsfind {
namespace {

QualifyResults qualify_simulation(const QualifyRequest& request) {
  const Simulation simulation = simulate_stages(request.simulation);
  if (!request.images.empty()) write_simulation(simulation, request.images);
  QualifyResults results;
  results.title =
      fmt::format("vsfind qualify: simulated stage, {}x{} pixels, bull's-eye of {}x{}, noise {:g}, blur {:g} px",
                  simulation_width, simulation_height, simulation.roi.width, simulation.roi.height,
                  request.simulation.noise, request.simulation.blur);
  for (const int accuracy : request.accuracies) {
    QualifyRow& row = results.rows.emplace_back();
    row.accuracy = accuracy;
    for (const SimulatedStage* stage : {&simulation.linear, &simulation.rotary}) {
      TrainOptions options;
      options.name = "bullseye";
      options.roi = simulation.roi;
      options.accuracy = accuracy;
      if (stage->kind == StageKind::rotary) options.angle_deg = {-45.0, 45.0};
      StageRequest wanted;
      wanted.pattern = std::make_shared<const Pattern>(train(simulation.training.view(), Mapping(), options));
      wanted.search = request.search;
      wanted.fiducials = request.fiducials;
      wanted.truth = stage->truth;
      row.name = options.name;
      row.points = pose_points(*wanted.pattern);
      const auto source = open_stage(*stage);
      StageRun run = std::move(run_stage(*source, {wanted}).front());
      StageAnalysis analysis = analyse_stage(run, stage->kind);
      (stage->kind == StageKind::linear ? row.linear : row.rotary) = StageTest{std::move(run), std::move(analysis)};
    }
  }
  results.settings = {
      {"target",
       "the sheet of the published experiment: bull's-eye 191x191 of concentric squares, a square in each corner"},
      {"translation test",
       fmt::format("{} steps of 1/3 px, two degrees off the vertical; searched at angle 0", request.simulation.steps)},
      {"rotation test",
       fmt::format("{} steps of 0.42 degrees; searched from -45 to 45 degrees", request.simulation.steps)},
      {"noise", fmt::format("{:g} grey levels, normal, then rounded to 8 bits", request.simulation.noise)},
      {"optics", fmt::format("Gaussian blur of {:g} px, area-sampled pixels", request.simulation.blur)},
      {"seed", fmt::format("{}", request.simulation.seed)},
      {"threads", fmt::format("{}", request.search.threads)},
  };
  return results;
}

std::unique_ptr<FrameSource> open_steps(const QualifyRequest& request) {
  if (!is_camera(request.source)) return open_sequence(request.source);
  StepChoice choice = request.steps;
  if (!log_is_quiet()) {
    choice.on_wait = [of = request.most_frames](std::size_t step) {
      fmt::print(stderr, "step {} of {}: Enter when the target stands still\n", step + 1, of);
    };
  }
  auto source = open_stepped(open_source(request.source, request.camera), std::move(choice));
  log_source_events(*source);
  return source;
}

QualifyResults qualify_sequence(const QualifyRequest& request) {
  SignalWatcher signals;  // before any other thread
  QualifyResults results;
  results.title = "vsfind qualify: " + request.source;
  const auto patterns = load_models(request.models);
  const auto source = open_steps(request);
  signals.on_signal([&source] { source->stop(); });
  results.mapping = mapping_for(request.source, source->info().pixel_aspect, request.mapping);
  check_units(patterns, results.mapping);
  check_region(request.search, source->info().width, source->info().height, request.source);
  std::vector<StageRequest> wanted;
  for (const auto& pattern : patterns) {
    StageRequest& one = wanted.emplace_back();
    one.pattern = pattern;
    one.search = request.search;
    one.mapping = results.mapping;
    one.field = request.field;
    one.fiducials = request.fiducials;
  }
  std::vector<StageRun> runs = run_stage(*source, wanted, request.most_frames);
  signals.on_signal({});
  for (StageRun& run : runs) {
    StageAnalysis analysis = analyse_stage(run, request.stage);
    if (request.fiducials.wanted && analysis.with_fiducials == 0) {
      spdlog::warn(
          "{}: no four squares of one size were found around the pattern; the results are relative to the travel "
          "alone (--fiducials X,Y,W,H, repeated, says where they are)",
          request.source);
    }
    QualifyRow& row = results.rows.emplace_back();
    row.name = run.pattern->name;
    row.accuracy = run.pattern->accuracy;
    row.points = pose_points(*run.pattern);
    (request.stage == StageKind::linear ? row.linear : row.rotary) = StageTest{std::move(run), std::move(analysis)};
  }
  std::string models;
  for (const auto& model : request.models) models += (models.empty() ? "" : ", ") + model;
  const Range angles = request.search.angle_deg.value_or(patterns.back()->angle_deg);
  results.settings = {
      {"sequence", request.source},
      {"models", models},
      {"stage", name(request.stage)},
      {"field", name(request.field)},
      {"angles searched", fmt::format("{:g} to {:g} degrees", angles.min, angles.max)},
      {"weakest score", fmt::format("{:g}", request.search.min_score)},
      {"calibration", request.mapping.calibration.empty() ? "none" : request.mapping.calibration},
      {"threads", fmt::format("{}", request.search.threads)},
  };
  return results;
}

int run_qualify(QualifyRequest& request) {
  complete_qualify_request(request);
  const QualifyResults results = request.simulate ? qualify_simulation(request) : qualify_sequence(request);
  if (!request.report.empty()) write_qualify_report(results, request.report);
  OutputFile("-").write(qualify_text(results));
  return exit_done;
}

std::function<int()> declare_qualify(CLI::App& app) {
  struct State {
    QualifyRequest request;
    Settings settings{qualify_settings(request)};
  };
  auto state = std::make_shared<State>();
  state->settings.declare(app);
  return [state] {
    state->settings.apply_command_line();
    return run_qualify(state->request);
  };
}

}  // namespace

Command qualify_command() {
  return {
      "qualify", "Measure accuracy on a target moved in steps, or on a simulated one",
      "A target with the pattern, and four squares of one size around it as fiducials, is moved by a stage in equal\n"
      "steps, a picture at each. Printed: how far the positions found lie from a straight line (or the angles from\n"
      "equal steps), how far the pattern lies from the fiducials, standard deviation and maximum, and the smallest\n"
      "standard deviation that the noise of the pictures allows. Lengths in the calibration's unit or px, angles in\n"
      "degrees, times in milliseconds, noise in grey levels of 255. The pictures come from a recording, from a "
      "folder,\n"
      "or from a camera as the stage moves.\n"
      "Example: vsfind qualify --simulate --accuracy 10,20,30 --report qualified\n"
      "Example: vsfind qualify stage.y4m --model part.vsm --stage rotary --report qualified\n"
      "Example: vsfind qualify gige: --frames 20 --take enter --model part.vsm --report qualified",
      declare_qualify};
}

}  // namespace vsfind
