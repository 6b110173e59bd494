#include "calibration/calibration_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>

#include "acquisition/errors.h"
#include "tests/calibration/cameras.h"

namespace vsfind {
namespace {

using testing::HasSubstr;

std::string complaint(const std::function<void()>& act) {
  try {
    act();
  } catch (const UsageError& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    return error.what();
  }
  return "no UsageError";
}

std::string complaint_of(const std::string& text) {
  return complaint([&text] { (void)parse_calibration(text, "c.yaml"); });
}

Calibration lens_calibration() {
  Calibration calibration;
  calibration.unit = "mm";
  calibration.image_width = 640;
  calibration.image_height = 480;
  calibration.made_from = Field::bottom;
  calibration.lens = test::lens_of(LensModel::polynomial, {-0.3, 0.12, 1e-3, -5e-4, 1.0 / 3.0});
  calibration.plane = test::slanted_plane(35.0, 5.0, 10.0, 500.0);
  calibration.pixel_aspect = 790.0 / 800.0;
  calibration.residuals = {54, 0.125, 0.5, {{"a \"b\"\\\n.png", 54, 0.125, 0.5}}};
  return calibration;
}

void expect_same(const Calibration& a, const Calibration& b) {
  EXPECT_EQ(a.unit, b.unit);
  EXPECT_EQ(a.image_width, b.image_width);
  EXPECT_EQ(a.image_height, b.image_height);
  EXPECT_EQ(a.made_from, b.made_from);
  EXPECT_DOUBLE_EQ(a.pixel_aspect, b.pixel_aspect);
  ASSERT_EQ(a.residuals.views.size(), b.residuals.views.size());
  EXPECT_EQ(a.residuals.points, b.residuals.points);
  for (std::size_t i = 0; i < a.residuals.views.size(); ++i) {
    EXPECT_EQ(a.residuals.views[i].name, b.residuals.views[i].name);
    EXPECT_EQ(a.residuals.views[i].rms, b.residuals.views[i].rms);
  }
  const Mapping first = mapping_of(a);
  const Mapping second = mapping_of(b);
  for (const Eigen::Vector2d& image : {Eigen::Vector2d(0, 0), {639, 0}, {320, 240}, {639, 479}}) {
    EXPECT_LT((first.plane_from_image(image) - second.plane_from_image(image)).norm(), 1e-9);
  }
}

TEST(CalibrationFile, GivesBackWhatWasSaved) {
  const Calibration lens = lens_calibration();
  expect_same(lens, parse_calibration(calibration_text(lens), "c.yaml"));
  Calibration fisheye = lens;
  fisheye.lens = test::lens_of(LensModel::fisheye, {-0.02, 0.01, -0.004, 0.001});
  expect_same(fisheye, parse_calibration(calibration_text(fisheye), "c.yaml"));
  Calibration plane = lens;
  plane.lens.reset();
  plane.plane.reset();
  plane.homography.emplace();
  *plane.homography << 1.7, 0.2, 310.0, -0.15, 1.4, 250.0, 1.1e-4, -7e-4, 1.0;
  expect_same(plane, parse_calibration(calibration_text(plane), "c.yaml"));
  const Calibration aspect = calibration_from_pixel_aspect(59.0 / 54.0);
  expect_same(aspect, parse_calibration(calibration_text(aspect), "c.yaml"));
  EXPECT_EQ(parse_calibration(calibration_text(aspect), "c.yaml").pixel_aspect, 59.0 / 54.0);
}

TEST(CalibrationFile, IsWrittenWholeOrNotAtAll) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "calibration_file";
  std::filesystem::create_directories(folder);
  const std::string path = folder / "c.yaml";
  save_calibration(lens_calibration(), path);
  save_calibration(lens_calibration(), path);
  expect_same(lens_calibration(), load_calibration(path));
  EXPECT_EQ(load_calibration(path).file, path);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1) << "something was left beside the file";
  EXPECT_THROW(save_calibration(lens_calibration(), folder / "none" / "c.yaml"), IoError);
  EXPECT_THROW((void)load_calibration(folder / "none.yaml"), IoError);
  EXPECT_THROW((void)load_calibration(folder), IoError);
}

TEST(CalibrationFile, ComplaintsNameLineKeyAndWhatIsAllowed) {
  const std::string head = "vsfind_calibration: 1\nunit: mm\n";
  EXPECT_EQ(complaint_of(head + "pixel_aspct: 1\n"),
            "c.yaml:3: pixel_aspct: unknown key (did you mean pixel_aspect?) (allowed: vsfind_calibration, checksum, "
            "unit, made_from, image_size, pixel_aspect, lens, plane, homography, residuals)");
  EXPECT_EQ(complaint_of(head + "pixel_aspect: 11\n"),
            "c.yaml:3: pixel_aspect: 11 is out of range (allowed: 0.1 to 10)");
  EXPECT_EQ(complaint_of(head + "pixel_aspect: wide\n"), "c.yaml:3: pixel_aspect: must be a number");
  EXPECT_EQ(complaint_of(head + "made_from: left\n"),
            "c.yaml:3: made_from: 'left' is not known (allowed: frame, top, bottom)");
  EXPECT_EQ(complaint_of("vsfind_calibration: 3\nunit: mm\n"),
            "c.yaml:1: vsfind_calibration: version 3 was made by a newer vsfind (allowed: up to 2)");
  EXPECT_THAT(complaint_of("camera_matrix: 1\n"), HasSubstr("--import"));
  EXPECT_THAT(complaint_of(head + "unit: px\n"), HasSubstr("c.yaml:3: unit: given twice"));
  EXPECT_THAT(complaint_of(head + "image_size: [640]\n"),
              HasSubstr("c.yaml:3: image_size: has 1 numbers, must be a list of 2"));
  EXPECT_THAT(complaint_of(head + "image_size: [640, 1e9]\n"),
              HasSubstr("c.yaml:3: image_size: 1000000000 is out of range"));
  EXPECT_THAT(complaint_of(head + "lens: 5\n"), HasSubstr("c.yaml:3: lens: expected keys"));
  EXPECT_THAT(complaint_of(head + "plane: {rotation: [0,0,0], translation: [0,0,1]}\n"),
              HasSubstr("c.yaml:3: plane: needs a lens"));
  EXPECT_THAT(complaint_of(head + "homography: [[1,0,0],[0,1,0],[0,0,1]]\n"), HasSubstr("image_size: missing"));
  EXPECT_THAT(complaint_of(head + "image_size: [9,9]\nhomography: [[1,0,0],[1,0,0],[0,0,1]]\n"),
              HasSubstr("cannot be inverted"));
  EXPECT_THAT(complaint_of(head + "pixel_aspect: .nan\n"), HasSubstr("must be a number"));
  const std::string lens =
      "image_size: [640, 480]\nlens: {model: polynomial, focal_length: [800, 790], principal_point: [320, 240], "
      "distortion: []}\nplane: {rotation: [0, 0, 0], translation: [0, 0, 500]}\n";
  EXPECT_EQ(complaint_of(head + lens), "no UsageError");
  EXPECT_THAT(complaint_of(head + lens + "pixel_aspect: 1.2\n"),
              HasSubstr("c.yaml:6: pixel_aspect: 1.2 contradicts the lens"));
}

TEST(CalibrationFile, ChecksumTellsAChangedNumberButNotARemark) {
  const std::string text = calibration_text(lens_calibration());
  EXPECT_EQ(complaint_of(text), "no UsageError");
  EXPECT_EQ(complaint_of("# camera 3\n" + text + "\n# end\n"), "no UsageError");
  std::string windows;
  for (const char c : text) windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
  EXPECT_EQ(complaint_of(windows), "no UsageError");
  // Any digit of any value.
  std::size_t tried = 0;
  for (std::size_t at = text.find("unit:"); at < text.size(); ++at) {
    if (text[at] == '#') at = text.find('\n', at);
    if (text[at] < '1' || text[at] > '8') continue;
    std::string changed = text;
    ++changed[at];
    EXPECT_NE(complaint_of(changed), "no UsageError") << "at " << at;
    ++tried;
  }
  EXPECT_GT(tried, 50U);
  std::string edited = text;
  const auto line = edited.find("checksum:");
  ASSERT_NE(line, std::string::npos);
  edited.replace(edited.find("unit: \"mm\""), 10, "unit: \"cm\"");
  EXPECT_THAT(complaint_of(edited), HasSubstr("c.yaml:2: checksum: does not suit the rest"));
  edited.erase(line, edited.find('\n', line) + 1 - line);
  EXPECT_EQ(complaint_of(edited), "no UsageError");
}

TEST(CalibrationFile, ReadsTheVersionsOfBefore) {
  for (const char* name : {"lens.yaml", "homography.yaml"}) {
    const Calibration old = load_calibration(VSFIND_SOURCE_DIR "/tests/fuzz/corpus/calibration/" + std::string(name));
    expect_same(old, parse_calibration(calibration_text(old), "c.yaml"));
  }
}

// Files that want to crash or exhaust the reader are refused in one line.
TEST(CalibrationFile, RefusesHostileFiles) {
  std::string nested;
  for (int i = 0; i < 20000; ++i) nested += '[';
  EXPECT_THAT(complaint_of("vsfind_calibration: 1\nunit: " + nested), HasSubstr("c.yaml:"));
  std::string bomb = "a: &a [1,1,1,1,1,1,1,1,1,1]\n";
  for (char c = 'b'; c < 'k'; ++c) {
    const std::string last(1, static_cast<char>(c - 1));
    bomb += std::string(1, c) + ": &" + c + " [";
    for (int i = 0; i < 10; ++i) bomb += (i == 0 ? "*" : ", *") + last;
    bomb += "]\n";
  }
  EXPECT_THAT(complaint_of(bomb), HasSubstr("more than 400000 values"));
  for (const char* text :
       {"", "\0\0", "- 1", "[", "{", "a: b: c", "? [1]\n: 2\n", "&a [*a]", "\xff\xfe", "%YAML:1.0\n---\n"}) {
    EXPECT_NE(complaint_of(text), "no UsageError") << text;
  }
  // Every cut and a changed byte at every place of a good file is taken or refused, nothing else.
  const std::string good = calibration_text(lens_calibration());
  for (std::size_t i = 0; i < good.size(); ++i) {
    (void)complaint_of(good.substr(0, i));
    const char bytes[] = {'\0', '[', ':', '"', '9', '\n', '\xff'};
    {
      const char c = bytes[i % std::size(bytes)];
      std::string changed = good;
      changed[i] = c;
      (void)complaint_of(changed);
    }
  }
}

TEST(CalibrationFile, FitsFramesAndFieldsOfItsCamera) {
  Calibration calibration = lens_calibration();
  calibration.file = "cam.yaml";
  calibration.image_width = 720;
  calibration.image_height = 577;
  EXPECT_NO_THROW(check_fits(calibration, 720, 577, Field::frame));
  EXPECT_NO_THROW(check_fits(calibration, 720, 289, Field::top));
  EXPECT_NO_THROW(check_fits(calibration, 720, 288, Field::bottom));
  EXPECT_NO_THROW(check_fits(calibration_from_pixel_aspect(1.1), 33, 44, Field::top));
  EXPECT_EQ(complaint([&] { check_fits(calibration, 640, 480, Field::frame); }),
            "cam.yaml: is for frames of 720x577 (fields of 720x289), but the image is a frame of 640x480");
  EXPECT_THAT(complaint([&] { check_fits(calibration, 720, 289, Field::frame); }),
              HasSubstr("say which one: top or bottom"));
  EXPECT_THAT(complaint([&] { check_fits(calibration, 720, 577, Field::top); }),
              HasSubstr("but the image is a top field of 720x577; it is as large as a whole frame"));
  EXPECT_THAT(complaint([&] { check_fits(calibration, 720, 289, Field::bottom); }), HasSubstr("fields of 720x288"));
}

}  // namespace
}  // namespace vsfind
