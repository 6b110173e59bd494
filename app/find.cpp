#include <exception>
#include <memory>

#include "acquisition/errors.h"
#include "acquisition/image_file.h"
#include "app/command.h"
#include "app/frame_searcher.h"
#include "app/program.h"
#include "app/result_output.h"
#include "app/run_options.h"

namespace vsfind {
namespace {

struct FindRequest {
  std::vector<std::string> images;
  RunOptions options;
};

std::vector<Setting> find_settings(FindRequest& request) {
  FindRequest* const r = &request;
  Setting images{"image", "IMAGE", "Pictures to search (PNG, PGM, TIFF, BMP, JPEG; colour becomes luma)",
                 [r](const std::vector<std::string>& v) {
                   for (const auto& value : v) r->images.push_back(parse_path(value));
                 }};
  images.positional = true;
  images.repeatable = true;
  std::vector<Setting> settings{images};
  for (auto& setting : run_settings(request.options,
                                    "frame: each image is a whole frame; top, bottom: it is that single field, of half "
                                    "the rows; split: it is an interlaced frame whose fields are searched, the top one "
                                    "first (default frame)")) {
    settings.push_back(std::move(setting));
  }
  return settings;
}

/// The field that an image itself is, and the fields to search of it.
FrameInfo info_of_image(FieldMode mode, std::size_t index) {
  FrameInfo info;
  info.sequence = index;
  info.order = FieldOrder::unknown;
  if (mode == FieldMode::top) info.field = Field::top;
  if (mode == FieldMode::bottom) info.field = Field::bottom;
  return info;
}

int run_find(FindRequest& request) {
  RunOptions& options = request.options;
  if (request.images.empty()) throw UsageError("find: an IMAGE is needed; see vsfind find --help");
  complete_run_options(options);
  FrameSearcher searcher(load_models(options.models), options, mapping_for("find", {}, options.mapping));

  // An image that cannot be read or searched costs its own rows only; the first failure decides the exit code.
  std::unique_ptr<ResultOutput> output;
  int code = exit_done;
  for (std::size_t i = 0; i < request.images.size(); ++i) {
    const std::string& path = request.images[i];
    FrameInfo info = info_of_image(options.field, i);
    std::optional<FrameResult> result;
    try {
      const Image image = load_image(path);
      info.arrival_ns = monotonic_ns();
      result = searcher.search(path, info, image.view());
    } catch (const std::exception&) {
      if (output) output->clear_progress();
      const int failed = report_error(std::current_exception());
      if (code == exit_done) code = failed;
      continue;
    }
    try {
      // Only now, so that a mistyped name of an image does not empty the rows of an earlier run.
      if (!output) output = std::make_unique<ResultOutput>(options, request.images.size());
      output->put(*result);
    } catch (const std::exception&) {
      if (output) output->clear_progress();
      code = report_error(std::current_exception());
      break;
    }
  }
  if (!output) return code;
  try {
    output->write_report();
  } catch (const std::exception&) {
    output->clear_progress();
    const int failed = report_error(std::current_exception());
    if (code == exit_done) code = failed;
  }
  output->finish();
  return code;
}

std::function<int()> declare_find(CLI::App& app) {
  struct State {
    FindRequest request;
    Settings settings{find_settings(request)};
  };
  auto state = std::make_shared<State>();
  state->settings.declare(app);
  return [state] {
    state->settings.apply_command_line();
    return run_find(state->request);
  };
}

}  // namespace

Command find_command() {
  return {"find", "Find trained patterns in pictures",
          "Rows: source is the image's path, frame its number among the arguments from 0, timestamp_ns 0; instance\n"
          "counts from 0, best first; x, y are calibrated coordinates (pixels, x times the pixel aspect), image_x,\n"
          "image_y frame pixels, angles degrees from +x toward +y, times milliseconds.\n"
          "Example: vsfind find scene1.png scene2.png --model part.vsm --angle -10:10 --csv rows.csv",
          declare_find};
}

}  // namespace vsfind
