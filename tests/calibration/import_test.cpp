#include "calibration/import.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

#include "acquisition/errors.h"
#include "tests/calibration/cameras.h"

namespace vsfind {
namespace {

using testing::HasSubstr;

const char* const ros = R"(image_width: 640
image_height: 480
camera_name: narrow_stereo
camera_matrix:
  rows: 3
  cols: 3
  data: [438.783367, 0.000000, 305.593336, 0.000000, 437.302876, 243.738352, 0.000000, 0.000000, 1.000000]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.361976, 0.110510, 0.001014, 0.000505, 0.000000]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
projection_matrix:
  rows: 3
  cols: 4
  data: [393.653800, 0.000000, 322.797939, 0.000000, 0.000000, 393.653800, 241.090902, 0.000000, 0.000000, 0.000000, 1.000000, 0.000000]
)";

const char* const kalibr = R"(cam0:
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [0.0034823894022493434, 0.0007150348452162257, -0.0020532361418706202, 0.00020293673591811182]
  distortion_model: equidistant
  intrinsics: [190.97847715128717, 190.9733070521226, 254.93170605935475, 256.8974428996504]
  resolution: [512, 512]
  rostopic: /cam0/image_raw
cam1:
  T_cn_cnm1:
  - [0.99, 0.0, 0.0, -0.1]
  - [0.0, 1.0, 0.0, 0.0]
  - [0.0, 0.0, 1.0, 0.0]
  - [0.0, 0.0, 0.0, 1.0]
  camera_model: pinhole
  distortion_coeffs: [-0.28, 0.07, 0.0002, 1.8e-05]
  distortion_model: radtan
  intrinsics: [461.6, 460.3, 362.7, 248.1]
  resolution: [752, 480]
)";

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return at == std::string::npos ? text : text.replace(at, what.size(), by);
}

std::string complaint_of(const std::string& text, const ImportOptions& options = {}) {
  try {
    (void)parse_foreign_calibration(text, "f.yaml", options);
  } catch (const UsageError& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    return error.what();
  }
  return "no UsageError";
}

// What OpenCV makes of a ray through such a lens.
Eigen::Vector2d projected_by_opencv(const Lens& lens, const Eigen::Vector2d& ray) {
  const PinholeCamera& c = lens.camera();
  const cv::Matx33d camera(c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1);
  const std::vector<cv::Point3d> points{{ray.x(), ray.y(), 1.0}};
  std::vector<cv::Point2d> pixels;
  const auto& k = lens.coefficients();
  if (lens.model() == LensModel::fisheye) {
    cv::fisheye::projectPoints(points, pixels, cv::Vec3d(), cv::Vec3d(), camera, cv::Vec4d(k[0], k[1], k[2], k[3]));
  } else {
    cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), camera, std::vector<double>(k.begin(), k.end()), pixels);
  }
  return {pixels[0].x, pixels[0].y};
}

void expect_projects_like_opencv(const Calibration& calibration) {
  const Lens& lens = *calibration.lens;
  for (const Eigen::Vector2d& ray : {Eigen::Vector2d(0, 0), {0.2, -0.1}, {-0.3, 0.25}, {0.05, 0.3}}) {
    EXPECT_LT((lens.pixel_from_ray(ray) - projected_by_opencv(lens, ray)).norm(), 1e-9);
  }
}

// A file made from single fields counts their rows; one made from frames serves fields as it is.
TEST(Import, FilesMadeFromFields) {
  const std::string of_fields = replaced(ros, "image_height: 480", "image_height: 240");
  const Lens frame = *parse_foreign_calibration(ros, "f.yaml").lens;
  for (const Field field : {Field::top, Field::bottom}) {
    const Calibration made = parse_foreign_calibration(of_fields, "f.yaml", {0, 0, 0, field});
    EXPECT_EQ(made.image_height, 480);
    EXPECT_EQ(made.made_from, field);
    EXPECT_NEAR(made.pixel_aspect, 2.0 * 437.302876 / 438.783367, 1e-12);
    for (const Eigen::Vector2d& ray : {Eigen::Vector2d(0.1, 0.2), Eigen::Vector2d(-0.2, 0.05)}) {
      // Where the file puts the ray in the field is where the mapping of that field finds it.
      const Eigen::Vector2d in_field = frame.pixel_from_ray(ray);
      EXPECT_LT((made.lens->pixel_from_ray(ray) - Mapping().for_field(field).frame_from_image(in_field)).norm(), 1e-9);
    }
    EXPECT_TRUE(*parse_foreign_calibration(ros, "f.yaml", {0, 640, 240, field}).lens == frame);
    EXPECT_EQ(parse_foreign_calibration(ros, "f.yaml", {0, 640, 240, field}).image_height, 480);
    EXPECT_EQ(parse_foreign_calibration(of_fields, "f.yaml", {0, 640, 240, field}).image_height, 480);
    EXPECT_EQ(complaint_of(ros, {0, 640, 200, field}), "f.yaml: is for images of 640x480, not 640x200");
  }
}

TEST(Import, RosPlumbBob) {
  const Calibration calibration = parse_foreign_calibration(ros, "f.yaml");
  EXPECT_EQ(calibration.image_width, 640);
  EXPECT_EQ(calibration.image_height, 480);
  EXPECT_EQ(calibration.unit, "px");
  EXPECT_EQ(calibration.lens->camera().fx, 438.783367);
  EXPECT_EQ(calibration.lens->camera().fy, 437.302876);
  EXPECT_EQ(calibration.lens->camera().cx, 305.593336);
  EXPECT_EQ(calibration.lens->camera().cy, 243.738352);
  EXPECT_EQ(calibration.lens->coefficients()[0], -0.361976);
  EXPECT_EQ(calibration.lens->coefficients()[3], 0.000505);
  expect_projects_like_opencv(calibration);
}

TEST(Import, RosRationalPolynomial) {
  std::string text = replaced(ros, "plumb_bob", "rational_polynomial");
  text = replaced(text, "cols: 5\n  data: [-0.361976, 0.110510, 0.001014, 0.000505, 0.000000]",
                  "cols: 8\n  data: [0.6, -0.2, 0.0008, 0.0003, 0.03, 0.9, 0.05, 0.01]");
  const Calibration calibration = parse_foreign_calibration(text, "f.yaml");
  EXPECT_EQ(calibration.lens->coefficients()[7], 0.01);
  expect_projects_like_opencv(calibration);
}

TEST(Import, RosMessage) {
  const Calibration calibration = parse_foreign_calibration(
      "header: {frame_id: cam}\nheight: 480\nwidth: 640\ndistortion_model: equidistant\nD: [-0.02, 0.01, -0.004, "
      "0.001]\n"
      "K: [800.0, 0, 320, 0, 790.0, 240, 0, 0, 1]\nbinning_x: 0\nbinning_y: 0\nroi: {x_offset: 0, y_offset: 0, height: "
      "0}\n",
      "f.yaml");
  EXPECT_EQ(calibration.lens->model(), LensModel::fisheye);
  expect_projects_like_opencv(calibration);
}

TEST(Import, OpenCvFileStorage) {
  const std::string path = std::filesystem::path(testing::TempDir()) / "opencv.yml";
  {
    cv::FileStorage file(path, cv::FileStorage::WRITE);
    file << "calibration_time"
         << "Thu 01 Jan 2015 12:00:00"
         << "image_width" << 640 << "image_height" << 480;
    file << "camera_matrix" << (cv::Mat_<double>(3, 3) << 800, 0, 322.3, 0, 790, 236.1, 0, 0, 1);
    file << "distortion_coefficients" << (cv::Mat_<double>(5, 1) << -0.3, 0.12, 1e-3, -5e-4, -0.05);
    file << "avg_reprojection_error" << 0.1 << "image_points" << cv::Mat(1, 54, CV_32FC2, cv::Scalar(1, 2));
  }
  const Calibration calibration = import_calibration(path);
  const Lens expected = test::lens_of(LensModel::polynomial, {-0.3, 0.12, 1e-3, -5e-4, -0.05});
  EXPECT_EQ(calibration.lens->coefficients(), expected.coefficients());
  EXPECT_EQ(calibration.lens->camera().cx, 322.3);
  expect_projects_like_opencv(calibration);
}

TEST(Import, OpenCvsOwnExamples) {
  const std::string folder = "/usr/share/doc/opencv-doc/examples/data/";
  if (!std::filesystem::exists(folder + "left_intrinsics.yml")) GTEST_SKIP() << "opencv-doc is not installed";
  const Calibration left = import_calibration(folder + "left_intrinsics.yml");
  EXPECT_NEAR(left.lens->camera().fx, 535.91573396163199, 1e-12);
  EXPECT_NEAR(left.lens->coefficients()[4], 0.23839153080878486, 1e-15);
  EXPECT_EQ(left.image_width, 640);
  // A stereo pair, which does not say the size.
  EXPECT_THROW((void)import_calibration(folder + "intrinsics.yml"), UsageError);
  const Calibration second = import_calibration(folder + "intrinsics.yml", {1, 640, 480});
  EXPECT_NE(second.lens->camera().cx, import_calibration(folder + "intrinsics.yml", {0, 640, 480}).lens->camera().cx);
}

TEST(Import, Kalibr) {
  const Calibration first = parse_foreign_calibration(kalibr, "f.yaml");
  EXPECT_EQ(first.lens->model(), LensModel::fisheye);
  EXPECT_EQ(first.lens->camera().cy, 256.8974428996504);
  EXPECT_EQ(first.image_width, 512);
  expect_projects_like_opencv(first);
  const Calibration second = parse_foreign_calibration(kalibr, "f.yaml", {1, 0, 0});
  EXPECT_EQ(second.lens->model(), LensModel::polynomial);
  EXPECT_EQ(second.lens->camera().fx, 461.6);
  EXPECT_EQ(second.image_width, 752);
  expect_projects_like_opencv(second);
}

// Without a view of a board the plane is the picture without its distortion.
TEST(Import, PlaneIsTheUndistortedPicture) {
  const Calibration calibration = parse_foreign_calibration(ros, "f.yaml");
  const Mapping mapping = mapping_of(calibration);
  const PinholeCamera& c = calibration.lens->camera();
  const double a = c.fy / c.fx;
  EXPECT_LT((mapping.plane_from_image({c.cx, c.cy}) - Eigen::Vector2d(a * c.cx, c.cy)).norm(), 1e-9);
  EXPECT_LT((mapping.plane_from_image({c.cx + 1.0, c.cy}) - Eigen::Vector2d(a * (c.cx + 1.0), c.cy)).norm(), 1e-4);
  // A barrel lens: the corner is drawn out.
  EXPECT_LT(mapping.plane_from_image({0.0, 0.0}).x(), -20.0);
  EXPECT_LT(mapping.plane_from_image({0.0, 0.0}).y(), -20.0);
}

TEST(Import, RefusesWhatItDoesNotKnow) {
  EXPECT_EQ(complaint_of(replaced(ros, "438.783367", "0")),
            "f.yaml:4: camera_matrix: its first number is 0: the camera was not calibrated");
  EXPECT_EQ(complaint_of(replaced(ros, "plumb_bob", "fov")),
            "f.yaml:8: distortion_model: 'fov' is not known (allowed: plumb_bob, rational_polynomial, equidistant)");
  EXPECT_THAT(complaint_of(replaced(ros, "438.783367, 0.000000", "438.783367, 0.5")), HasSubstr("a skew of 0.5"));
  EXPECT_THAT(complaint_of(replaced(ros, "438.783367, ", "")), HasSubstr("has 8 numbers, but rows x cols is 3x3"));
  EXPECT_THAT(complaint_of(replaced(ros, "438.783367", "-1")), HasSubstr("focal length"));
  EXPECT_THAT(complaint_of(replaced(ros, "image_width: 640\n", "")), HasSubstr("does not say the size of the images"));
  EXPECT_THAT(complaint_of(replaced(ros, "image_width: 640", "image_width: 1e7")), HasSubstr("f.yaml:1: image_width"));
  EXPECT_THAT(complaint_of(ros, {0, 720, 576}), HasSubstr("is for images of 640x480, not 720x576"));
  EXPECT_THAT(complaint_of("roi: {x_offset: 5, y_offset: 0}\n" + std::string(ros)), HasSubstr("roi.x_offset"));
  EXPECT_THAT(complaint_of("a: 1\n"), HasSubstr("holds no camera matrix (known: ROS"));
  EXPECT_THAT(complaint_of("vsfind_calibration: 1\n"), HasSubstr("nothing to import"));
  EXPECT_THAT(complaint_of(kalibr, {2, 0, 0}), HasSubstr("cam2: missing"));
  EXPECT_THAT(complaint_of(replaced(kalibr, "pinhole", "omni")), HasSubstr("cam0.camera_model: 'omni'"));
  EXPECT_THAT(complaint_of(replaced(kalibr, "equidistant", "fov")), HasSubstr("cam0.distortion_model: 'fov'"));
  EXPECT_THAT(complaint_of(replaced(kalibr, "[190.97847715128717, ", "[")),
              HasSubstr("cam0.intrinsics: has 3 numbers"));
  EXPECT_THROW((void)import_calibration("/none.yaml"), IoError);
}

TEST(Import, SurvivesDamage) {
  int taken = 0;
  for (const std::string& good : {std::string(ros), std::string(kalibr)}) {
    const char bytes[] = {'\0', '[', ':', '"', '9', '\n', '-', '\xff'};
    for (std::size_t i = 0; i < good.size(); ++i) {
      std::string changed = good;
      changed[i] = bytes[i % std::size(bytes)];
      taken += complaint_of(changed) == "no UsageError" ? 1 : 0;
      (void)complaint_of(good.substr(0, i));
    }
  }
  EXPECT_GT(taken, 100);
}

}  // namespace
}  // namespace vsfind
