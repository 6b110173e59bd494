#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <memory>

#include "acquisition/camera.h"
#include "acquisition/errors.h"
#include "acquisition/reconnecting_source.h"
#include "app/command.h"
#include "app/frame_searcher.h"
#include "app/live_options.h"
#include "app/log.h"
#include "app/pipeline.h"
#include "app/program.h"
#include "app/recorder.h"
#include "app/result_output.h"
#include "app/source_events.h"

namespace vsfind {
namespace {

std::unique_ptr<FrameSource> open_live(const LiveSource& wanted, std::optional<double> give_up_after) {
  require_backend(wanted.uri);
  if (parse_source_uri(wanted.uri).scheme == SourceUri::Scheme::file) return open_source(wanted.uri, wanted.camera);
  ReconnectOptions options;
  if (give_up_after)
    options.give_up_after =
        std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::duration<double>(*give_up_after));
  auto source = open_reconnecting(
      wanted.uri, [uri = wanted.uri, camera = wanted.camera] { return open_source(uri, camera); }, options);
  log_source_events(*source);
  return source;
}

/// One source with what belongs to it, in the order in which it is needed.
struct OpenLane {
  std::unique_ptr<FrameSource> source;
  std::unique_ptr<FrameSearcher> searcher;
  std::unique_ptr<Recorder> recorder;
};

Lane lane_of(const LiveSource& wanted, OpenLane& open) {
  Lane lane;
  lane.source = open.source.get();
  lane.searcher = open.searcher.get();
  lane.recorder = open.recorder.get();
  lane.search = wanted.options.search;
  lane.drop_oldest = open.source->info().live;
  const MappingChoice& choice = wanted.options.mapping;
  if (choice.calibration.empty() && !choice.pixel_aspect) lane.follow = choice;
  return lane;
}

int run_live(LiveRequest& request) {
  SignalWatcher signals;  // before the threads of sources and searches
  std::vector<OpenLane> open(request.sources.size());
  std::vector<Lane> lanes;
  for (std::size_t i = 0; i < open.size(); ++i) {
    const LiveSource& wanted = request.sources[i];
    const MappingChoice& choice = wanted.options.mapping;
    const bool is_known = !choice.calibration.empty() || choice.pixel_aspect;
    open[i].searcher =
        std::make_unique<FrameSearcher>(load_models(wanted.options.models), wanted.options,
                                        is_known ? mapping_for(wanted.uri, {}, choice) : SourceMapping{});
    open[i].source = open_live(wanted, request.give_up_after);
    const SourceInfo& info = open[i].source->info();  // of a camera it is known with its first frame
    check_region(wanted.options.search, info.width, info.height, info.name);
    if (!wanted.record.empty()) open[i].recorder = std::make_unique<Recorder>(wanted.record);
    lanes.push_back(lane_of(wanted, open[i]));
  }
  ResultOutput output(request.sources.front().options, std::nullopt, request.row_files);
  output.show_latency();
  PipelineOptions options;
  options.max_frames = request.frames;
  options.max_seconds = request.seconds;
  const std::exception_ptr error = run_pipeline(lanes, output, signals, options);
  output.clear_progress();
  int code = error ? report_error(error) : exit_done;
  std::uint64_t lost = output.lost();
  for (const auto& lane : open) {
    if (!lane.recorder) continue;
    lane.recorder->close();
    lost += lane.recorder->lost();
  }
  if (lost > 0) {
    spdlog::error("{} rows, pictures or recorded frames could not be written", lost);
    if (code == exit_done) code = exit_io;
  }
  output.finish();
  for (const auto& lane : open) {
    const std::string text = lane.source->statistics();
    if (!text.empty() && !log_is_quiet()) fmt::print(stderr, "vsfind: {}: {}\n", lane.source->info().name, text);
  }
  return code;
}

std::function<int()> declare_live(CLI::App& app) {
  struct State {
    LiveRequest request;
    Settings settings{live_settings(request)};
  };
  auto state = std::make_shared<State>();
  state->settings.declare(app);
  app.add_option("--config", state->request.config,
                 "Take settings from a YAML file: options' names with _ for -; under sources: a list of sources,\n"
                 "each with settings of its own; its paths are relative to its folder; what the command line\n"
                 "says goes before it")
      ->type_name("FILE");
  return [state] {
    complete_live_request(state->request, state->settings);
    return run_live(state->request);
  };
}

}  // namespace

Command live_command() {
  return {
      "live", "Find trained patterns in the frames of cameras, as they come",
      "Rows: source is the URI, frame the camera's own counter (a gap is a lost or dropped frame), timestamp_ns\n"
      "the camera's time; otherwise as in replay. Where the search does not keep up, the oldest waiting frame is\n"
      "dropped and counted. A camera that is absent or lost is waited for and reopened; a frame that did not\n"
      "arrive whole gives a row bad_frame. SIGINT and SIGTERM finish the frames in hand, then comes the summary.\n"
      "Example: vsfind live --source gige:192.168.1.20 --exposure 2000 --model part.vsm --csv rows.csv --rotate day",
      declare_live};
}

}  // namespace vsfind
