#include "calibration/calibration_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <span>
#include <string_view>
#include <system_error>

#include "acquisition/errors.h"
#include "calibration/key_reader.h"
#include "calibration/rotation.h"
#include "calibration/yaml_tree.h"

namespace vsfind {
namespace {

// Larger frames are not taken from anywhere.
constexpr int largest_side = 65536;
constexpr double largest_residual = 1e9;

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      result += '\\';
      result += c;
    } else if (byte < 0x20 || byte == 0x7f) {
      result += fmt::format("\\x{:02x}", byte);
    } else {
      result += c;
    }
  }
  return result + '"';
}

// Shortest digits that read back as the same number.
std::string list(std::span<const double> values) { return fmt::format("[{}]", fmt::join(values, ", ")); }

std::string residuals_text(const Residuals& residuals) {
  std::string text = fmt::format("residuals:  # frame pixels\n  points: {}\n  rms: {:.6g}\n  worst: {:.6g}\n",
                                 residuals.points, residuals.rms, residuals.worst);
  if (!residuals.views.empty()) text += "  views:\n";
  for (const ViewResidual& view : residuals.views) {
    text += fmt::format("    - {{name: {}, points: {}, rms: {:.6g}, worst: {:.6g}}}\n", quoted(view.name), view.points,
                        view.rms, view.worst);
  }
  return text;
}

Residuals read_residuals(const std::string& file, KeyReader reader) {
  Residuals residuals;
  residuals.points = reader.whole("points", 0, 100000000);
  residuals.rms = reader.number("rms", 0.0, largest_residual);
  residuals.worst = reader.number("worst", 0.0, largest_residual);
  if (const YamlNode* views = reader.find("views")) {
    if (views->kind != YamlNode::Kind::list) reader.fail("views", "must be a list");
    for (const YamlNode& item : views->items) {
      KeyReader view(file, item, "residuals.views.");
      ViewResidual& residual = residuals.views.emplace_back();
      residual.name = view.text("name");
      residual.points = view.whole("points", 0, 100000000);
      residual.rms = view.number("rms", 0.0, largest_residual);
      residual.worst = view.number("worst", 0.0, largest_residual);
      view.refuse_unknown();
    }
  }
  reader.refuse_unknown();
  return residuals;
}

Lens read_lens(const std::string& file, KeyReader reader) {
  const std::string model = reader.text("model");
  if (model != "polynomial" && model != "fisheye") {
    reader.fail("model", fmt::format("'{}' is not known (allowed: polynomial, fisheye)", shown(model)));
  }
  const std::vector<double> focal = reader.numbers("focal_length", 2);
  const std::vector<double> principal = reader.numbers("principal_point", 2);
  const std::vector<double> distortion = reader.numbers("distortion");
  reader.refuse_unknown();
  try {
    return Lens(model == "fisheye" ? LensModel::fisheye : LensModel::polynomial,
                {focal[0], focal[1], principal[0], principal[1]}, distortion);
  } catch (const UsageError& error) {
    throw UsageError(fmt::format("{}: lens: {}", file, error.what()));
  }
}

PlanePose read_plane(KeyReader reader) {
  const std::vector<double> rotation = reader.numbers("rotation", 3);
  const std::vector<double> translation = reader.numbers("translation", 3);
  reader.refuse_unknown();
  PlanePose plane;
  const Eigen::Vector3d turn(rotation[0], rotation[1], rotation[2]);
  if (!(turn.norm() < 100.0)) reader.fail("rotation", "is out of range (axis times angle in radians)");
  plane.rotation = rotation_from_vector(turn);
  plane.translation = {translation[0], translation[1], translation[2]};
  return plane;
}

Field read_field(KeyReader& reader, const std::string& key) {
  const std::string word = reader.text(key);
  for (const Field field : {Field::frame, Field::top, Field::bottom}) {
    if (word == name(field)) return field;
  }
  reader.fail(key, fmt::format("'{}' is not known (allowed: frame, top, bottom)", shown(word)));
}

void check_version(KeyReader& reader, const std::string& file) {
  if (!reader.has("vsfind_calibration")) {
    throw UsageError(file +
                     ": no calibration of vsfind: its first key would be vsfind_calibration (files of other programs: "
                     "vsfind calibrate --import)");
  }
  const int version = reader.whole("vsfind_calibration", 1, 1000000);
  if (version > calibration_file_version) {
    reader.fail("vsfind_calibration", fmt::format("version {} was made by a newer vsfind (allowed: up to {})", version,
                                                  calibration_file_version));
  }
}

/// Of the lines that say something, without comments and the checksum's own line: another line end or a remark does
/// not change it.
std::string checksum_of(std::string_view text) {
  constexpr std::string_view blanks = " \t\r";
  uLong sum = crc32_z(0, nullptr, 0);
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.starts_with("checksum:")) continue;
    if (line.starts_with('#')) continue;
    line = line.substr(0, line.find(" #"));
    const std::size_t last = line.find_last_not_of(blanks);
    if (last == std::string_view::npos) continue;
    const std::string said = std::string(line.substr(0, last + 1)) + '\n';
    sum = crc32_z(sum, reinterpret_cast<const Bytef*>(said.data()), said.size());
  }
  return fmt::format("{:08x}", sum);
}

void check_checksum(KeyReader& reader, const std::string& text) {
  if (!reader.has("checksum")) return;
  const std::string right = checksum_of(text);
  if (reader.text("checksum") == right) return;
  reader.fail("checksum",
              "does not suit the rest: the file is damaged, or was edited (after editing it by hand take "
              "this line out)");
}

}  // namespace

std::string calibration_text(const Calibration& calibration) {
  const std::string version = fmt::format("vsfind_calibration: {}\n", calibration_file_version);
  std::string text = fmt::format("unit: {}  # of plane coordinates\n", quoted(calibration.unit));
  if (calibration.image_width > 0) {
    text += fmt::format("image_size: [{}, {}]  # of the whole frame, pixels\n", calibration.image_width,
                        calibration.image_height);
  }
  text += fmt::format("made_from: {}  # frame, top or bottom: what the pictures held\n", name(calibration.made_from));
  text += fmt::format("pixel_aspect: {}  # pixel width over pixel height\n", calibration.pixel_aspect);
  if (calibration.lens) {
    const Lens& lens = *calibration.lens;
    const PinholeCamera& c = lens.camera();
    const bool fisheye = lens.model() == LensModel::fisheye;
    const auto count = static_cast<std::size_t>(lens.coefficient_count());
    text += fmt::format(
        "lens:\n  model: {}\n  focal_length: {}  # fx, fy, frame pixels\n  principal_point: {}\n"
        "  distortion: {}  # {}\n",
        name(lens.model()), list(std::vector{c.fx, c.fy}), list(std::vector{c.cx, c.cy}),
        list(std::span(lens.coefficients()).first(count)),
        fisheye ? "k1 k2 k3 k4" : "k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4, as many as are used");
    const PlanePose plane = calibration.plane ? *calibration.plane : undistorted_picture_plane(lens);
    const Eigen::Vector3d turn = vector_from_rotation(plane.rotation);
    text += fmt::format(
        "plane:  # camera = R(rotation) (x, y, 0) + translation\n  rotation: {}  # axis times angle, radians\n"
        "  translation: {}\n",
        list(std::span(turn.data(), 3)), list(std::span(plane.translation.data(), 3)));
  } else if (calibration.homography) {
    const Eigen::Matrix3d rows = calibration.homography->transpose();  // columns are contiguous
    text += fmt::format("homography:  # frame pixels from plane coordinates\n  - {}\n  - {}\n  - {}\n",
                        list(std::span(rows.col(0).data(), 3)), list(std::span(rows.col(1).data(), 3)),
                        list(std::span(rows.col(2).data(), 3)));
  }
  if (calibration.residuals.points > 0) text += residuals_text(calibration.residuals);
  return version +
         fmt::format("checksum: \"{}\"  # of what follows; take this line out after editing by hand\n",
                     checksum_of(version + text)) +
         text;
}

Calibration parse_calibration(const std::string& text, const std::string& file) {
  const YamlNode root = parse_yaml(text, file);
  if (root.kind != YamlNode::Kind::map) throw UsageError(file + ": no calibration: it has no keys");
  KeyReader reader(file, root);
  check_version(reader, file);
  check_checksum(reader, text);
  Calibration calibration;
  calibration.file = file;
  calibration.unit = reader.text("unit");
  if (calibration.unit.empty() || calibration.unit.size() > 32) reader.fail("unit", "must be of 1 to 32 letters");
  if (calibration.unit.find_first_of(",\"\n\r") != std::string::npos) {
    reader.fail("unit", "must not contain commas, quotes or line ends");
  }
  if (reader.has("made_from")) calibration.made_from = read_field(reader, "made_from");
  if (reader.has("image_size")) {
    const std::vector<double> size = reader.numbers("image_size", 2);
    for (const double side : size) {
      if (!(side >= 1.0 && side <= largest_side) || side != std::floor(side)) {
        reader.fail("image_size",
                    fmt::format("{} is out of range (allowed: whole pixels, 1 to {})", side, largest_side));
      }
    }
    calibration.image_width = static_cast<int>(size[0]);
    calibration.image_height = static_cast<int>(size[1]);
  }
  const bool aspect_given = reader.has("pixel_aspect");
  if (aspect_given) calibration.pixel_aspect = reader.number("pixel_aspect", 0.1, 10.0);
  if (reader.has("lens")) calibration.lens = read_lens(file, reader.map("lens"));
  if (reader.has("plane")) calibration.plane = read_plane(reader.map("plane"));
  if (reader.has("homography")) {
    const std::vector<double> h = reader.numbers("homography", 9);
    calibration.homography.emplace();
    *calibration.homography << h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], h[8];
  }
  if (reader.has("residuals")) calibration.residuals = read_residuals(file, reader.map("residuals"));
  reader.refuse_unknown();

  if (calibration.plane && !calibration.lens) reader.fail("plane", "needs a lens beside it");
  if (calibration.lens && !calibration.plane) reader.fail("lens", "needs a plane beside it");
  if (calibration.lens && calibration.homography) reader.fail("homography", "cannot stand beside a lens");
  if ((calibration.lens || calibration.homography) && calibration.image_width == 0) {
    throw UsageError(file + ": image_size: missing");
  }
  if (calibration.lens) {
    const PinholeCamera& c = calibration.lens->camera();
    // Whoever edits one of the two should not be left with a file that says two things.
    if (aspect_given && std::abs(calibration.pixel_aspect / (c.fy / c.fx) - 1.0) > 0.01) {
      reader.fail("pixel_aspect",
                  fmt::format("{} contradicts the lens, whose fy/fx is {}", calibration.pixel_aspect, c.fy / c.fx));
    }
    calibration.pixel_aspect = c.fy / c.fx;
  }
  try {
    (void)mapping_of(calibration);
  } catch (const UsageError& error) {
    throw UsageError(fmt::format("{}: {}", file, error.what()));
  }
  return calibration;
}

void save_calibration(const Calibration& calibration, const std::string& path) {
  const std::string text = calibration_text(calibration);
  struct stat status {};
  // Pipes and devices cannot be replaced by a new file.
  const bool replace = ::stat(path.c_str(), &status) != 0 || S_ISREG(status.st_mode);
  const std::string target = replace ? path + ".part" : path;
  const auto failed = [&](const char* what) {
    const int reason = errno;
    if (replace) std::remove(target.c_str());
    throw IoError(fmt::format("{}: {}: {}", path, what, std::generic_category().message(reason)));
  };
  errno = 0;
  std::ofstream stream(target, std::ios::binary);
  if (!stream) failed("cannot be written");
  stream << text << std::flush;
  stream.close();
  if (!stream) failed("cannot be written");
  if (replace && std::rename(target.c_str(), path.c_str()) != 0) failed("cannot be replaced");
}

Calibration load_calibration(const std::string& path) { return parse_calibration(read_small_file(path), path); }

}  // namespace vsfind
