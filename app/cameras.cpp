#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "acquisition/camera.h"
#include "app/camera_report.h"
#include "app/command.h"
#include "app/log.h"
#include "app/output_file.h"
#include "app/program.h"

namespace vsfind {
namespace {

int run_cameras(bool json) {
  const auto cameras = list_cameras();
  OutputFile out("-");
  if (json) {
    out.write_line(cameras_json(cameras));
    return exit_done;
  }
  for (const CameraDescription& camera : cameras) out.write_line(camera_line(camera));
  if (cameras.empty() && !log_is_quiet()) fmt::print(stderr, "no camera found\n");
  return exit_done;
}

std::function<int()> declare_cameras(CLI::App& app) {
  auto json = std::make_shared<bool>(false);
  app.add_flag("--json", *json, "All that is known, for programs: an array of objects");
  return [json] { return run_cameras(*json); };
}

}  // namespace

Command cameras_command() {
  return {
      "cameras", "List the cameras that can be opened",
      "A line per camera: the URI for --source of live and record, model, serial number, where it is, pixel formats\n"
      "with sizes (pixels) and frames per second, what timestamps tell, and in brackets why it cannot be opened now.\n"
      "Formats whose luma must be converted are only counted; --json lists them all. V4L2 devices are asked what\n"
      "their present input offers; GigE Vision cameras must be reachable by a broadcast. Takes about a second.\n"
      "Example: vsfind cameras",
      declare_cameras};
}

}  // namespace vsfind
