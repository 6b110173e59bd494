#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>

#include "acquisition/errors.h"
#include "acquisition/image_file.h"
#include "app/calibration_picture.h"
#include "app/calibration_report.h"
#include "app/command.h"
#include "app/drawing.h"
#include "app/output_file.h"
#include "app/program.h"
#include "app/settings.h"
#include "calibration/board.h"
#include "calibration/calibration_file.h"
#include "calibration/import.h"
#include "calibration/point_pairs.h"
#include "calibration/solve.h"
#include "calibration/yaml_tree.h"

namespace vsfind {
namespace {

struct CalibrateRequest {
  std::vector<std::string> images;
  std::string output;
  std::string overlay;
  std::string points;
  std::string import;
  std::string plane;
  std::optional<BoardSpec> board;
  std::optional<double> pitch;
  std::optional<PixelAspect> pixel_aspect;
  std::optional<std::string> unit;
  int width = 0;
  int height = 0;
  int camera = 0;
  bool no_lens = false;
  std::optional<int> distortion;
  Field field = Field::frame;
};

/// `WxH` in whole pixels.
void parse_size(const std::string& text, int& width, int& height) {
  const std::size_t cross = text.find('x');
  if (cross == std::string::npos) throw ValueError("'" + text + "' is no size (allowed: WxH in pixels, as in 640x480)");
  width = parse_whole(text.substr(0, cross), 1, image_max_side);
  height = parse_whole(text.substr(cross + 1), 1, image_max_side);
}

std::string parse_unit(const std::string& text) {
  if (text.empty() || text.size() > 32 || text.find_first_of(",\"\n\r") != std::string::npos) {
    throw ValueError("'" + text + "' is no unit (allowed: 1 to 32 letters without commas and quotes)");
  }
  return text;
}

std::vector<Setting> calibrate_settings(CalibrateRequest& request) {
  CalibrateRequest* const r = &request;
  using Values = const std::vector<std::string>&;
  std::vector<Setting> settings;
  const auto add = [&settings](std::string name, std::string value, std::string help, auto set) -> Setting& {
    return settings.emplace_back(Setting{std::move(name), std::move(value), std::move(help), std::move(set)});
  };
  Setting& images = add("image", "PLATE", "Pictures of the board, all of one size (PNG, PGM, TIFF, BMP, JPEG)",
                        [r](Values v) { r->images = v; });
  images.positional = true;
  images.repeatable = true;
  add("board", "KIND:COLSxROWS",
      "What the pictures show: chessboard (inner corners), circles (dark on light or light on dark), charuco (squares; "
      "any "
      "dictionary), as in chessboard:9x6",
      [r](Values v) {
        try {
          r->board = parse_board(v[0]);
        } catch (const UsageError& error) {
          throw ValueError(error.what());
        }
      })
      .excludes = {"points"};
  add("pitch", "P", "Side of a square, or distance of the circles' centres, in the unit",
      [r](Values v) { r->pitch = parse_number(v[0], 1e-9, 1e9); });
  add("points", "PAIRS.csv",
      "Points measured by hand instead of a board: columns image_x,image_y (pixels of the picture), world_x,world_y "
      "(in "
      "the unit); at least four, no three on a line",
      [r](Values v) { r->points = parse_path(v[0]); });
  add("import", "FILE",
      "Take the lens from a ROS camera_info YAML, an OpenCV FileStorage YAML or a Kalibr camchain; alone, the plane is "
      "the "
      "undistorted picture; with --board or --points these give the plane",
      [r](Values v) { r->import = parse_path(v[0]); });
  add("camera", "N", "Which camera of an imported file that holds several, from 0 (default 0)",
      [r](Values v) { r->camera = parse_whole(v[0], 0, 1000); });
  add("pixel-aspect", "W:H",
      "Pixel width to height of a whole frame; also pal (59:54) or ntsc (10:11); alone it is the calibration",
      [r](Values v) { r->pixel_aspect = parse_pixel_aspect(v[0]); })
      .excludes = {"import"};
  add("image-size", "WxH", "Pixels of the pictures (of a single field: its own rows), where no picture tells it",
      [r](Values v) { parse_size(v[0], r->width, r->height); });
  add("unit", "NAME", "Unit of the pitch or of the world points, and of what is found later (default mm)",
      [r](Values v) { r->unit = parse_unit(v[0]); });
  add("field", "frame|top|bottom",
      "What the pictures are (those behind an imported file, too): whole frames, or single fields of half the rows; "
      "the calibration serves both (default frame)",
      [r](Values v) {
        r->field = parse_word<Field>(v[0], {{"frame", Field::frame}, {"top", Field::top}, {"bottom", Field::bottom}});
      });
  add("plane", "PLATE", "The picture whose board is the plane (default: the last one)",
      [r](Values v) { r->plane = parse_path(v[0]); });
  add("no-lens", "", "Solve the plane alone, from its picture", [r](Values v) {
    r->no_lens = parse_switch(v[0]);
  }).excludes = {"import", "distortion"};
  add("distortion", "0|2|4|5|8",
      "How many coefficients describe the lens: k1 k2, p1 p2, k3, k4 k5 k6 (rational) (default 5)", [r](Values v) {
        r->distortion = parse_word<int>(v[0], {{"0", 0}, {"2", 2}, {"4", 4}, {"5", 5}, {"8", 8}});
      });
  add("overlay", "FILE.png", "Draw detected and reprojected points with magnified residuals, and the plane's grid",
      [r](Values v) { r->overlay = parse_path(v[0]); });
  add("output", "FILE", "File for the calibration, YAML (needed)", [r](Values v) {
    r->output = parse_path(v[0]);
  }).letter = 'o';
  return settings;
}

SolveOptions solve_options(const CalibrateRequest& request) {
  SolveOptions options;
  options.unit = request.unit.value_or("mm");
  options.made_from = request.field;
  options.pixel_aspect = request.pixel_aspect ? request.pixel_aspect->value : 1.0;
  options.solve_lens = !request.no_lens;
  options.distortion = request.distortion.value_or(5);
  return options;
}

/// The size of the whole frames that a picture or a field of this size comes from.
void set_frame_size(SolveOptions& options, int width, int height) {
  options.image_width = width;
  options.image_height = height * line_step(options.made_from);
}

void take_imported_lens(const CalibrateRequest& request, SolveOptions& options) {
  if (request.import.empty()) return;
  const Calibration imported = import_calibration(
      request.import,
      {request.camera, options.image_width, options.image_height / line_step(request.field), request.field});
  options.lens = imported.lens;
}

void write_results(const CalibrateRequest& request, const Solution& solution, const std::string& plane,
                   const ImageView& image, const BoardView* view) {
  save_calibration(solution.calibration, request.output);
  if (!request.overlay.empty() && view != nullptr) {
    write_png(request.overlay, calibration_picture(image, request.field, solution.calibration, *view));
  }
  for (const auto& warning : solution.warnings) spdlog::warn("{}", warning);
  OutputFile("-").write(describe(solution, plane));
}

int run_board(const CalibrateRequest& request) {
  if (request.images.empty()) throw UsageError("--board: pictures of the board are needed");
  if (!request.pitch)
    throw UsageError("--pitch is needed: the side of a square, or the distance of the circles' centres");
  const std::string plane = request.plane.empty() ? request.images.back() : request.plane;
  if (std::find(request.images.begin(), request.images.end(), plane) == request.images.end()) {
    throw UsageError("--plane " + plane + " is none of the pictures given");
  }
  BoardSpec spec = *request.board;
  spec.pitch = *request.pitch;
  SolveOptions options = solve_options(request);
  std::vector<BoardView> views;
  Image plane_image;
  bool plane_seen = false;
  int width = request.width;
  int height = request.height;
  for (const std::string& path : request.images) {
    // Without a lens to solve only the plane's picture counts.
    if ((request.no_lens || !request.import.empty()) && path != plane) continue;
    const Image image = load_image(path);
    const ImageView& pixels = image.view();
    if (width == 0) {
      width = pixels.width;
      height = pixels.height;
    } else if (pixels.width != width || pixels.height != height) {
      throw UsageError(fmt::format("{}: is of {}x{}, the others are of {}x{} (allowed: pictures of one size)", path,
                                   pixels.width, pixels.height, width, height));
    }
    const auto view = find_board(pixels, request.field, spec, path);
    if (!view) {
      if (path == plane) throw UsageError(path + ": the board is not seen in the picture of the plane");
      spdlog::warn("{}: the board is not seen: left out", path);
      continue;
    }
    if (path == plane) {
      plane_image = image;
      plane_seen = true;
      options.plane_view = views.size();
    }
    views.push_back(*view);
  }
  if (!plane_seen) throw UsageError(plane + ": the board is not seen in the picture of the plane");
  set_frame_size(options, width, height);
  take_imported_lens(request, options);
  const Solution solution = solve_views(views, options);
  write_results(request, solution, plane, plane_image.view(), &views[options.plane_view]);
  return exit_done;
}

int run_points(const CalibrateRequest& request) {
  if (request.images.size() > 1) throw UsageError("--points: at most one picture (for its size and the overlay)");
  SolveOptions options = solve_options(request);
  Image image;
  if (!request.images.empty()) {
    image = load_image(request.images[0]);
    const ImageView& pixels = image.view();
    if (request.width != 0 && (pixels.width != request.width || pixels.height != request.height)) {
      throw UsageError(fmt::format("{}: is of {}x{}, not of --image-size {}x{}", request.images[0], pixels.width,
                                   pixels.height, request.width, request.height));
    }
    set_frame_size(options, pixels.width, pixels.height);
  } else if (request.width != 0) {
    set_frame_size(options, request.width, request.height);
  } else {
    throw UsageError("--image-size is needed: WxH in pixels (or a picture)");
  }
  take_imported_lens(request, options);
  BoardView used;
  const Solution solution =
      solve_points(parse_point_pairs(read_small_file(request.points), request.points), options, request.points, used);
  write_results(request, solution, request.points, image.view(), &used);
  return exit_done;
}

int run_import(const CalibrateRequest& request) {
  if (!request.images.empty()) throw UsageError("--import: pictures need --board beside it");
  if (!request.overlay.empty())
    throw UsageError("--overlay: there is no picture to draw over (allowed: with --board or --points)");
  if (request.unit)
    throw UsageError("--unit: an imported lens alone has the unit px (allowed: with --board or --points)");
  Solution solution;
  solution.calibration =
      import_calibration(request.import, {request.camera, request.width, request.height, request.field});
  write_results(request, solution, "the undistorted picture", {}, nullptr);
  return exit_done;
}

int run_aspect(const CalibrateRequest& request) {
  if (!request.images.empty()) throw UsageError("--pixel-aspect: pictures need --board beside it");
  if (!request.overlay.empty())
    throw UsageError("--overlay: there is no picture to draw over (allowed: with --board or --points)");
  if (request.unit)
    throw UsageError("--unit: a pixel aspect alone has the unit px (allowed: with --board or --points)");
  Solution solution;
  solution.calibration = calibration_from_pixel_aspect(request.pixel_aspect->value);
  solution.calibration.made_from = request.field;
  solution.calibration.image_width = request.width;
  solution.calibration.image_height = request.height * line_step(request.field);
  write_results(request, solution, "the picture with square pixels", {}, nullptr);
  return exit_done;
}

int run_calibrate(const CalibrateRequest& request) {
  if (request.output.empty()) throw UsageError("--output is needed: the file for the calibration");
  if (request.board) return run_board(request);
  if (!request.points.empty()) return run_points(request);
  if (!request.import.empty()) return run_import(request);
  if (request.pixel_aspect) return run_aspect(request);
  throw UsageError("calibrate: what from? (allowed: pictures with --board, --points, --import, --pixel-aspect)");
}

std::function<int()> declare_calibrate(CLI::App& app) {
  struct State {
    CalibrateRequest request;
    Settings settings{calibrate_settings(request)};
  };
  auto state = std::make_shared<State>();
  state->settings.declare(app);
  return [state] {
    state->settings.apply_command_line();
    return run_calibrate(state->request);
  };
}

}  // namespace

Command calibrate_command() {
  return {
      "calibrate", "Learn where image points lie in the world: lens, plane, unit",
      "One picture gives the plane; several (about ten, the board tilted by 20 to 45 degrees to different sides, over "
      "the whole image) give the lens, too.\n"
      "Board coordinates: (0,0) is the first inner corner or circle, x along the columns, y along the rows.\n"
      "Example: vsfind calibrate view*.png --board chessboard:9x6 --pitch 25 --unit mm --overlay check.png -o "
      "camera.yaml",
      declare_calibrate};
}

}  // namespace vsfind
