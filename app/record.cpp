#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <limits>
#include <memory>
#include <utility>

#include "acquisition/camera.h"
#include "acquisition/errors.h"
#include "acquisition/reconnecting_source.h"
#include "app/camera_options.h"
#include "app/command.h"
#include "app/log.h"
#include "app/program.h"
#include "app/progress.h"
#include "app/record_run.h"
#include "app/settings.h"
#include "app/source_events.h"

namespace vsfind {
namespace {

struct RecordRequest {
  std::string source;
  std::string output;
  RecordLimits limits;
  double give_up_after_s = 10.0;
  CameraSettings camera;
};

std::vector<Setting> record_settings(RecordRequest& request) {
  RecordRequest* const r = &request;
  using Values = const std::vector<std::string>&;
  constexpr double max_seconds = 1e7;
  std::vector<Setting> settings;
  settings.push_back({"source", "URI", "v4l2:/dev/videoN, gige:NAME-OR-ADDRESS, gige: (the first one), file:SEQUENCE",
                      [r](Values v) { r->source = v[0]; }});
  Setting output{"output", "FILE.y4m", "The recording; a file of that name is replaced",
                 [r](Values v) { r->output = parse_path(v[0]); }};
  output.letter = 'o';
  output.path = true;
  settings.push_back(std::move(output));
  settings.push_back(
      {"frames", "N", "Stop after so many frames; single fields count as one each (default: no limit)", [r](Values v) {
         r->limits.frames = static_cast<std::uint64_t>(parse_whole(v[0], 1, std::numeric_limits<int>::max()));
       }});
  settings.push_back({"seconds", "S", "Stop so many seconds after the first frame (default: no limit)",
                      [r](Values v) { r->limits.seconds = parse_number(v[0], 1e-3, max_seconds); }});
  settings.push_back({"give-up-after", "S",
                      "A camera that is lost is waited for so many seconds; 0: not at all (default 10)",
                      [r](Values v) { r->give_up_after_s = parse_number(v[0], 0.0, max_seconds); }});
  for (Setting& setting : camera_settings(request.camera)) settings.push_back(std::move(setting));
  return settings;
}

std::unique_ptr<FrameSource> open(const RecordRequest& request) {
  const SourceUri uri = parse_source_uri(request.source);
  if (uri.scheme == SourceUri::Scheme::file) {
    std::error_code ignored;
    if (std::filesystem::equivalent(uri.name, request.output, ignored))
      throw UsageError(fmt::format("record: {} would be written over itself: name another --output", request.output));
    return open_source(request.source, request.camera);
  }
  // Opened here for the first time: a camera that is not there, or set wrongly, is told of at once.
  auto first = std::make_shared<std::unique_ptr<FrameSource>>(open_source(request.source, request.camera));
  ReconnectOptions options;
  options.give_up_after = std::chrono::milliseconds(static_cast<std::int64_t>(request.give_up_after_s * 1e3));
  const std::string name = (*first)->info().name;
  return open_reconnecting(
      name,
      [first, uri_text = request.source, camera = request.camera] {
        return *first ? std::move(*first) : open_source(uri_text, camera);
      },
      options);
}

std::string summary_of(const Recorded& recorded, const std::string& statistics) {
  constexpr double megabyte = 1e6;
  std::string text =
      fmt::format("{} frames in {:.1f} s, {:.1f} MB, {} bad, {} missing", recorded.frames, recorded.seconds,
                  static_cast<double>(recorded.bytes) / megabyte, recorded.bad, recorded.gaps);
  if (!statistics.empty()) text += "; camera: " + statistics;
  return text;
}

int run_record(const RecordRequest& request) {
  if (request.source.empty()) throw UsageError("record: --source is needed");
  if (request.output.empty()) throw UsageError("record: -o FILE.y4m is needed");
  SignalWatcher signals;  // before the threads of the source
  const auto source = open(request);
  log_source_events(*source);
  const auto total = request.limits.frames > 0 ? std::optional(request.limits.frames) : source->info().frames;
  Progress progress(!log_is_quiet(), false, total);
  const Recorded recorded =
      record(*source, request.output, request.limits, signals, [&](std::uint64_t done) { progress.update(done); });
  progress.clear();
  const int code = recorded.error ? report_error(recorded.error) : exit_done;
  if (!log_is_quiet()) fmt::print(stderr, "{}\n", summary_of(recorded, source->statistics()));
  return code;
}

std::function<int()> declare_record(CLI::App& app) {
  struct State {
    RecordRequest request;
    Settings settings{record_settings(request)};
  };
  auto state = std::make_shared<State>();
  state->settings.declare(app);
  return [state] {
    state->settings.apply_command_line();
    return run_record(state->request);
  };
}

}  // namespace

Command record_command() {
  return {"record", "Write what a camera sees to a recording, losslessly",
          "Nothing is dropped: while the disk is slow frames wait in memory (up to 256 MiB of them). Frame numbers,\n"
          "timestamps, fields and bad frames are kept, so that replay gives the rows that live would have given. A\n"
          "camera that is lost is waited for, and the gap shows in the frame numbers. SIGINT and SIGTERM write what\n"
          "was captured and end. Where the disk is full the file ends with a whole frame; where the frames change\n"
          "their size, recording goes on in FILE-2.y4m.\n"
          "Example: vsfind record --source v4l2:/dev/video0 --standard PAL --size 720x576 --seconds 60 -o line.y4m",
          declare_record};
}

}  // namespace vsfind
