#include "finder/train.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <filesystem>
#include <memory>

#include "acquisition/errors.h"
#include "acquisition/image_file.h"
#include "app/command.h"
#include "app/model_report.h"
#include "app/output_file.h"
#include "app/program.h"
#include "app/settings.h"
#include "app/source_mapping.h"
#include "finder/model_file.h"

namespace vsfind {
namespace {

struct TrainRequest {
  std::string image;
  std::string output;
  std::string mask;
  std::vector<std::string> against;
  bool named = false;
  bool roi_given = false;
  MappingChoice mapping;
  Field field = Field::frame;
  TrainOptions options;
};

std::vector<Setting> train_settings(TrainRequest& request) {
  TrainRequest* const r = &request;
  TrainOptions* const o = &request.options;
  using Values = const std::vector<std::string>&;
  std::vector<Setting> settings;
  const auto add = [&settings](std::string name, std::string value, std::string help, auto set) -> Setting& {
    return settings.emplace_back(Setting{std::move(name), std::move(value), std::move(help), std::move(set)});
  };
  add("image", "IMAGE", "Picture that shows the pattern (PNG, PGM, TIFF, BMP, JPEG; colour becomes luma)",
      [r](Values v) { r->image = parse_path(v[0]); })
      .positional = true;
  add("roi", "X,Y,W,H", "Rectangle around the pattern, pixels of the image (needed)", [r, o](Values v) {
    o->roi = parse_roi(v[0]);
    r->roi_given = true;
  });
  add("output", "MODEL", "File for the trained model (needed)", [r](Values v) {
    r->output = parse_path(v[0]);
  }).letter = 'o';
  add("name", "NAME", "Name of the pattern in the results (default: the model file's name without its ending)",
      [r, o](Values v) {
        if (v[0].empty()) throw ValueError("'' is not a name (allowed: any text that is not empty)");
        o->name = v[0];
        r->named = true;
      });
  add("origin", "X,Y", "Point of the image that x, y of the results stand for, pixels (default: the ROI's centre)",
      [o](Values v) { o->origin = parse_point(v[0]); });
  add("mask", "MASK.png", "Picture as large as the image or the ROI; what is not zero is part of the pattern",
      [r](Values v) { r->mask = parse_path(v[0]); });
  add("angle", "MIN:MAX", "Angles at which the pattern will be looked for, degrees (default 0:0)",
      [o](Values v) { o->angle_deg = parse_range(v[0], -360.0, 360.0, "degrees"); });
  add("scale", "MIN:MAX", "Scales at which it will be looked for, both axes alike, 0.5 to 2 (default 1:1)",
      [o](Values v) {
        o->scale_x = o->scale_y = parse_range(v[0], 0.5, 2.0, "");
        o->common_scale = true;
      })
      .excludes = {"scale-x", "scale-y"};
  add("scale-x", "MIN:MAX", "Scales along the pattern's x alone, 0.5 to 2 (default 1:1)",
      [o](Values v) { o->scale_x = parse_range(v[0], 0.5, 2.0, ""); });
  add("scale-y", "MIN:MAX", "Scales along the pattern's y alone, 0.5 to 2 (default 1:1)",
      [o](Values v) { o->scale_y = parse_range(v[0], 0.5, 2.0, ""); });
  add("accuracy", "1..100", "How many points the final pose may use: more is finer and slower (default 30)",
      [o](Values v) { o->accuracy = parse_whole(v[0], 1, 100); });
  add("edges", "", "Match gradients instead of grey values", [o](Values v) { o->edges = parse_switch(v[0]); });
  add("edge-threshold", "auto|VALUE",
      "Weakest edge that counts, grey levels (of 255) per pixel, 0.01 to 255 (default auto)", [o](Values v) {
        if (v[0] == "auto") {
          o->edge_threshold.reset();
          return;
        }
        o->edge_threshold = parse_number(v[0], least_edge_threshold, 255.0);
      });
  add("polarity", "same|reversed|any", "Whether bright stays bright (default same)", [o](Values v) {
    o->polarity = parse_word<Polarity>(
        v[0], {{"same", Polarity::same}, {"reversed", Polarity::reversed}, {"any", Polarity::any}});
  });
  add("spread", "", "Spread the points evenly, so that any one part of the pattern may be lost",
      [o](Values v) { o->spread = parse_switch(v[0]); });
  add("against", "IMAGE", "Further scene whose content must not be taken for the pattern (repeatable)", [r](Values v) {
    r->against.clear();
    for (const auto& value : v) r->against.push_back(parse_path(value));
  }).repeatable = true;
  add("calibration", "FILE", "Calibration of the camera: the pattern is learnt as it lies on its plane, in its unit",
      [r](Values v) {
        r->mapping = {parse_path(v[0]), std::nullopt};
      })
      .excludes = {"pixel-aspect"};
  add("pixel-aspect", "W:H", "Pixel width to height of a whole frame; also pal (59:54) or ntsc (10:11) (default 1:1)",
      [r](Values v) {
        r->mapping = {{}, parse_pixel_aspect(v[0])};
      });
  add("field", "frame|top|bottom",
      "What the image is: a whole frame, or a single field of half the rows; --roi and --origin count its own rows "
      "(default frame)",
      [r](Values v) {
        r->field = parse_word<Field>(v[0], {{"frame", Field::frame}, {"top", Field::top}, {"bottom", Field::bottom}});
      });
  return settings;
}

void check_roi(const Roi& roi, const ImageView& image, const std::string& path) {
  if (roi.x + roi.width <= image.width && roi.y + roi.height <= image.height) return;
  throw UsageError(fmt::format("--roi {},{},{},{} reaches outside {} (allowed: within its {}x{} pixels)", roi.x, roi.y,
                               roi.width, roi.height, path, image.width, image.height));
}

void check_mask(const ImageView& mask, const Roi& roi, const ImageView& image, const std::string& path) {
  if (mask.bits != 8) throw UsageError(fmt::format("--mask {} has {} bits (allowed: 8)", path, mask.bits));
  if ((mask.width == image.width && mask.height == image.height) ||
      (mask.width == roi.width && mask.height == roi.height)) {
    return;
  }
  throw UsageError(fmt::format("--mask {} is {}x{} pixels (allowed: {}x{} as the image, or {}x{} as the ROI)", path,
                               mask.width, mask.height, image.width, image.height, roi.width, roi.height));
}

int run_train(TrainRequest& request) {
  if (request.image.empty()) throw UsageError("train: an IMAGE is needed; see vsfind train --help");
  if (!request.roi_given) throw UsageError("--roi is needed: X,Y,W,H in pixels of the image");
  if (request.output.empty()) throw UsageError("--output is needed: the file for the trained model");
  TrainOptions& options = request.options;
  if (!request.named) options.name = std::filesystem::path(request.output).stem().string();

  const Image image = load_image(request.image);
  check_roi(options.roi, image.view(), request.image);
  Image mask;
  if (!request.mask.empty()) {
    mask = load_image(request.mask);
    check_mask(mask.view(), options.roi, image.view(), request.mask);
    options.mask = mask.view();
  }
  std::vector<Image> against;
  for (const auto& path : request.against) {
    against.push_back(load_image(path));
    options.against.push_back(against.back().view());
  }
  const SourceMapping mapping = mapping_for(request.image, {}, request.mapping);
  mapping.check_size(image.view().width, image.view().height, request.field);
  options.unit = mapping.unit;

  const Pattern pattern = train(image.view(), mapping.mapping.for_field(request.field), options);
  save_model(pattern, request.output);
  for (const auto& warning : pattern.report.warnings) spdlog::warn("{}: {}", pattern.name, warning);
  OutputFile("-").write(describe(pattern));
  return exit_done;
}

std::function<int()> declare_train(CLI::App& app) {
  struct State {
    TrainRequest request;
    Settings settings{train_settings(request)};
  };
  auto state = std::make_shared<State>();
  state->settings.declare(app);
  return [state] {
    state->settings.apply_command_line();
    return run_train(state->request);
  };
}

}  // namespace

Command train_command() {
  return {"train", "Learn a pattern from one picture and write a model file",
          "Positions are pixels, integers at pixel centres; an ROI X,Y,W,H covers X ... X+W-1, so its centre is\n"
          "X+(W-1)/2. Angles are degrees, positive from +x toward +y (clockwise on the screen).\n"
          "What training found out is printed on stdout.\n"
          "Example: vsfind train part.png --roi 220,140,191,191 --angle -45:45 -o part.vsm",
          declare_train};
}

}  // namespace vsfind
