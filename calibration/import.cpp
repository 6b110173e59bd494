#include "calibration/import.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <optional>
#include <span>
#include <vector>

#include "acquisition/errors.h"
#include "calibration/key_reader.h"
#include "calibration/yaml_tree.h"

namespace vsfind {
namespace {

constexpr int largest_side = 65536;

// The first of several spellings of a key that the map has.
std::optional<std::string> first_of(KeyReader& reader, std::initializer_list<const char*> keys) {
  for (const char* key : keys) {
    if (reader.has(key)) return key;
  }
  return std::nullopt;
}

// Numbers as a list (ROS messages), or as a map with rows, cols and data (ROS files, OpenCV).
std::vector<double> matrix(KeyReader& reader, const std::string& key) {
  if (reader.get(key).kind == YamlNode::Kind::list) return reader.numbers(key);
  KeyReader inside = reader.map(key);
  std::vector<double> values =
      inside.get("data").kind == YamlNode::Kind::null ? std::vector<double>{} : inside.numbers("data");
  if (inside.has("rows") && inside.has("cols")) {
    const int rows = inside.whole("rows", 0, 10000);
    const int cols = inside.whole("cols", 0, 10000);
    if (static_cast<std::size_t>(rows) * static_cast<std::size_t>(cols) != values.size()) {
      inside.fail("data", fmt::format("has {} numbers, but rows x cols is {}x{}", values.size(), rows, cols));
    }
  }
  return values;
}

// Cuts zeros at the end down to the longest form that a lens takes.
std::vector<double> trimmed(std::vector<double> k) {
  while (k.size() > 12 && k.back() == 0.0) k.pop_back();
  constexpr std::array<std::size_t, 5> forms{0, 4, 5, 8, 12};
  // Two numbers (k1 k2) are common, others are filled up to the next form.
  const auto next = std::find_if(forms.begin(), forms.end(), [&k](std::size_t n) { return n >= k.size(); });
  if (next != forms.end()) k.resize(*next, 0.0);
  return k;
}

Lens make_lens(const KeyReader& reader, const std::string& key, LensModel model, const PinholeCamera& camera,
               const std::vector<double>& coefficients) {
  if (model == LensModel::polynomial && coefficients.size() > 12 &&
      std::any_of(coefficients.begin() + 12, coefficients.end(), [](double k) { return k != 0.0; })) {
    reader.fail(key, "a tilted sensor (coefficients 13 and 14) is not known here (allowed: up to 12)");
  }
  try {
    return Lens(model, camera, model == LensModel::polynomial ? trimmed(coefficients) : coefficients);
  } catch (const UsageError& error) {
    reader.fail(key, error.what());
  }
}

// A lens by which a field's rows are counted, as one for the frame's: y_frame = 2 y_field + first line.
Lens for_frames(const Lens& lens, Field field) {
  const PinholeCamera& c = lens.camera();
  const double step = line_step(field);
  const auto used = std::span(lens.coefficients()).first(static_cast<std::size_t>(lens.coefficient_count()));
  return Lens(lens.model(), {c.fx, c.fy * step, c.cx, c.cy * step + first_line(field)}, used);
}

// `width` and `height` as the file says; 0: it does not.
Calibration finished(const Lens& lens, const std::string& file, const ImportOptions& options, int width, int height) {
  if (width == 0 || height == 0) {
    if (options.image_width == 0) {
      throw UsageError(file + ": does not say the size of the images (give it: --image-size WxH)");
    }
    width = options.image_width;
    height = options.image_height;
  }
  const bool known = options.image_width != 0;
  const int step = line_step(options.field);
  const bool of_frames =
      step == 1 || (known && (options.field == Field::top ? (height + 1) / 2 : height / 2) == options.image_height);
  const int picture_height = of_frames && step > 1 ? options.image_height : height;
  if (known && (options.image_width != width || options.image_height != picture_height)) {
    throw UsageError(fmt::format("{}: is for images of {}x{}, not {}x{}", file, width, height, options.image_width,
                                 options.image_height));
  }
  Calibration calibration;
  calibration.lens = of_frames ? lens : for_frames(lens, options.field);
  calibration.plane = undistorted_picture_plane(*calibration.lens);
  calibration.image_width = width;
  calibration.image_height = of_frames ? height : height * step;
  calibration.made_from = options.field;
  calibration.pixel_aspect = calibration.lens->camera().fy / calibration.lens->camera().fx;
  if (!(calibration.pixel_aspect >= 0.1 && calibration.pixel_aspect <= 10.0)) {
    throw UsageError(
        fmt::format("pixel aspect fy/fx {} is out of range (allowed: 0.1 to 10)", calibration.pixel_aspect));
  }
  return calibration;
}

PinholeCamera camera_of_matrix(const KeyReader& reader, const std::string& key, const std::vector<double>& k) {
  if (k.size() != 9) reader.fail(key, fmt::format("has {} numbers, must be a 3x3 matrix", k.size()));
  if (k[0] == 0.0) reader.fail(key, "its first number is 0: the camera was not calibrated");
  if (k[1] != 0.0) reader.fail(key, fmt::format("a skew of {} is not known here (allowed: 0)", k[1]));
  if (k[3] != 0.0 || k[6] != 0.0 || k[7] != 0.0 || k[8] != 1.0)
    reader.fail(key, "is no camera matrix [fx 0 cx; 0 fy cy; 0 0 1]");
  return {k[0], k[4], k[2], k[5]};
}

// Images that the driver cut or binned after the calibration do not have its coordinates.
void refuse_binning(KeyReader& reader) {
  for (const char* key : {"binning_x", "binning_y"}) {
    if (reader.has(key) && reader.number(key) > 1.0)
      reader.fail(key, "binned images are not known here (allowed: 0, 1)");
  }
  if (!reader.has("roi") || reader.get("roi").kind != YamlNode::Kind::map) return;
  KeyReader roi = reader.map("roi");
  for (const char* key : {"x_offset", "y_offset"}) {
    if (roi.has(key) && roi.number(key) != 0.0) roi.fail(key, "a part of the image is not known here (allowed: 0)");
  }
}

LensModel model_of(KeyReader& reader) {
  if (reader.has("fisheye_model") && reader.number("fisheye_model") != 0.0) return LensModel::fisheye;
  if (!reader.has("distortion_model") || reader.get("distortion_model").kind == YamlNode::Kind::null) {
    return LensModel::polynomial;
  }
  const std::string model = reader.text("distortion_model");
  if (model == "equidistant" || model == "fisheye") return LensModel::fisheye;
  for (const char* known : {"", "none", "plumb_bob", "rational_polynomial", "radtan", "thin_prism"}) {
    if (model == known) return LensModel::polynomial;
  }
  reader.fail("distortion_model",
              fmt::format("'{}' is not known (allowed: plumb_bob, rational_polynomial, equidistant)", shown(model)));
}

Calibration from_ros_or_opencv(KeyReader reader, const std::string& file, const ImportOptions& options) {
  const std::string number = std::to_string(options.camera + 1);
  const auto matrix_key =
      first_of(reader, {"camera_matrix", "Camera_Matrix", "cameraMatrix", "K", "k", ("M" + number).c_str()});
  if (!matrix_key) reader.fail("camera_matrix", "missing");
  const PinholeCamera camera = camera_of_matrix(reader, *matrix_key, matrix(reader, *matrix_key));
  const auto coefficients_key = first_of(reader, {"distortion_coefficients", "Distortion_Coefficients", "distCoeffs",
                                                  "dist_coeffs", "D", "d", ("D" + number).c_str()});
  const LensModel model = model_of(reader);
  const std::vector<double> coefficients = coefficients_key ? matrix(reader, *coefficients_key) : std::vector<double>{};
  refuse_binning(reader);
  const Lens lens = make_lens(reader, coefficients_key.value_or(*matrix_key), model, camera, coefficients);
  const auto width_key = first_of(reader, {"image_width", "image_Width", "width"});
  const auto height_key = first_of(reader, {"image_height", "image_Height", "height"});
  return finished(lens, file, options, width_key ? reader.whole(*width_key, 1, largest_side) : 0,
                  height_key ? reader.whole(*height_key, 1, largest_side) : 0);
}

Calibration from_kalibr(KeyReader chain, const std::string& file, const ImportOptions& options) {
  const std::string key = fmt::format("cam{}", options.camera);
  KeyReader reader = chain.map(key);
  const std::string camera_model = reader.text("camera_model");
  if (camera_model != "pinhole") {
    reader.fail("camera_model", fmt::format("'{}' is not known here (allowed: pinhole)", shown(camera_model)));
  }
  const std::vector<double> k = reader.numbers("intrinsics", 4);
  if (k[0] == 0.0) reader.fail("intrinsics", "the first number is 0: the camera was not calibrated");
  const std::string model = reader.has("distortion_model") ? reader.text("distortion_model") : "none";
  std::vector<double> coefficients;
  if (model == "radtan" || model == "equidistant") {
    coefficients = reader.numbers("distortion_coeffs", 4);
  } else if (model != "none") {
    reader.fail("distortion_model",
                fmt::format("'{}' is not known here (allowed: radtan, equidistant, none)", shown(model)));
  }
  const Lens lens = make_lens(reader, "intrinsics", model == "equidistant" ? LensModel::fisheye : LensModel::polynomial,
                              {k[0], k[1], k[2], k[3]}, coefficients);
  int width = 0;
  int height = 0;
  if (reader.has("resolution")) {
    const std::vector<double> size = reader.numbers("resolution", 2);
    for (const double side : size) {
      if (!(side >= 1.0 && side <= largest_side) || side != std::floor(side)) {
        reader.fail("resolution", fmt::format("{} is out of range (allowed: 1 to {})", side, largest_side));
      }
    }
    width = static_cast<int>(size[0]);
    height = static_cast<int>(size[1]);
  }
  return finished(lens, file, options, width, height);
}

}  // namespace

Calibration parse_foreign_calibration(const std::string& text, const std::string& file, const ImportOptions& options) {
  const YamlNode root = parse_yaml(text, file);
  const std::string known = " (known: ROS camera_info, OpenCV FileStorage YAML with camera_matrix, Kalibr camchain)";
  if (root.kind != YamlNode::Kind::map) throw UsageError(file + ": no calibration: it has no keys" + known);
  KeyReader reader(file, root);
  if (reader.has("vsfind_calibration"))
    throw UsageError(file + ": is a calibration of vsfind already, nothing to import");
  const auto camera_key = [](const std::string& key) {
    return key.size() > 3 && key.starts_with("cam") && key.find_first_not_of("0123456789", 3) == std::string::npos;
  };
  if (std::any_of(root.keys.begin(), root.keys.end(), camera_key)) return from_kalibr(reader, file, options);
  const std::string stereo = fmt::format("M{}", options.camera + 1);
  if (!first_of(reader, {"camera_matrix", "Camera_Matrix", "cameraMatrix", "K", "k", stereo.c_str()})) {
    throw UsageError(file + ": holds no camera matrix" + known);
  }
  return from_ros_or_opencv(reader, file, options);
}

Calibration import_calibration(const std::string& path, const ImportOptions& options) {
  return parse_foreign_calibration(read_small_file(path), path, options);
}

}  // namespace vsfind
