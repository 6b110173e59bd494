// Train and find through a calibration, from the outside: units, angles, fields, and what is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "app/render/patterns.h"
#include "app/render/sensor.h"
#include "app/render/truth.h"
#include "calibration/calibration_file.h"
#include "tests/app/shell.h"
#include "tests/calibration/cameras.h"

namespace vsfind {
namespace {

using test::csv_rows;
using test::Outcome;
using testing::HasSubstr;

constexpr double millimetres = 0.6;  // to a unit of the drawing: about a pixel in the middle

class CalibratedProgram : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<test::TemporaryFolder>();
    Calibration calibration;
    calibration.unit = "mm";
    calibration.image_width = 640;
    calibration.image_height = 480;
    calibration.lens = test::lens_of(LensModel::polynomial, {-0.3, 0.12, 1e-3, -5e-4, 0.0});
    calibration.pixel_aspect = calibration.lens->camera().fy / calibration.lens->camera().fx;
    calibration.plane = test::slanted_plane(35.0, 5.0, 10.0, 500.0);
    save_calibration(calibration, file("camera.yaml"));
    mapping_ = mapping_of(calibration);
    write("train.png", render::develop(expose(trained_, Field::frame), {}));
    // The box around the drawing in the picture.
    const Eigen::Vector2d middle = mapping_.image_from_plane({trained_.x, trained_.y});
    const Roi roi{static_cast<int>(middle.x()) - 82, static_cast<int>(middle.y()) - 62, 165, 125};
    origin_ = mapping_.plane_from_image(render::roi_centre(roi));
    const Outcome outcome = test::vsfind({"train", file("train.png"), "--roi", fmt_roi(roi), "--angle", "-60:60",
                                          "--calibration", file("camera.yaml"), "-o", file("part.vsm")});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("mm"));
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static std::string file(const std::string& name) { return *folder_ / name; }

  static std::string fmt_roi(const Roi& r) {
    return std::to_string(r.x) + "," + std::to_string(r.y) + "," + std::to_string(r.width) + "," +
           std::to_string(r.height);
  }

  static void write(const std::string& name, const render::Picture& picture) {
    const ImageView v = picture.view();
    cv::imwrite(file(name), cv::Mat(v.height, v.width, CV_8U, const_cast<std::byte*>(v.data)));
  }

  static render::Exposure expose(const Pose& pose, Field lines) {
    render::Scene scene;
    scene.frame_from_plane = [](const Eigen::Vector2d& p) { return mapping_.image_from_plane(p); };
    scene.items.push_back({render::artwork(3, 150.0, 130.0), pose});
    return render::expose(scene, 0.7, lines);
  }

  static Outcome find(const std::string& picture, std::vector<std::string> more) {
    std::vector<std::string> arguments{"find", file(picture), "--model", file("part.vsm"), "--csv", "-"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return test::vsfind(arguments);
  }

  static void expect_pose(const std::map<std::string, std::string>& row, const Pose& scene, double mm, double degrees) {
    const Pose truth = render::expected_pose(trained_, scene, origin_);
    EXPECT_EQ(row.at("status"), "found");
    EXPECT_EQ(row.at("unit"), "mm");
    EXPECT_NEAR(std::stod(row.at("x")), truth.x, mm);
    EXPECT_NEAR(std::stod(row.at("y")), truth.y, mm);
    EXPECT_NEAR(std::stod(row.at("angle_deg")), truth.angle_deg, degrees);
    const Eigen::Vector2d frame = mapping_.image_from_plane({truth.x, truth.y});
    EXPECT_NEAR(std::stod(row.at("image_x")), frame.x(), 0.1);
    EXPECT_NEAR(std::stod(row.at("image_y")), frame.y(), 0.1);
  }

  static inline std::unique_ptr<test::TemporaryFolder> folder_;
  static inline Mapping mapping_;
  static inline Eigen::Vector2d origin_;
  static inline const Pose trained_{5.0, -4.0, 0.0, millimetres, millimetres};
};

TEST_F(CalibratedProgram, FindsInMillimetresAnywhere) {
  for (const Pose& pose :
       {Pose{-110.0, -80.0, 37.0, millimetres, millimetres}, Pose{75.0, 70.0, -51.0, millimetres, millimetres}}) {
    write("scene.png", render::develop(expose(pose, Field::frame), {}));
    const Outcome outcome = find("scene.png", {"--calibration", file("camera.yaml")});
    const auto rows = csv_rows(outcome.out);
    ASSERT_EQ(rows.size(), 1U) << outcome.err;
    expect_pose(rows[0], pose, 0.03, 0.04);
  }
}

TEST_F(CalibratedProgram, FieldsOfTheSameCameraNeedNoOtherCalibration) {
  const Pose pose{-60.0, 40.0, 20.0, millimetres, millimetres};
  const render::Exposure top = expose(pose, Field::top);
  write("woven.png", render::develop(render::weave(top, expose(pose, Field::bottom)), {}));
  const auto rows = csv_rows(find("woven.png", {"--calibration", file("camera.yaml"), "--field", "split"}).out);
  ASSERT_EQ(rows.size(), 2U);
  expect_pose(rows[0], pose, 0.05, 0.08);
  expect_pose(rows[1], pose, 0.05, 0.08);
  write("top.png", render::develop(top, {}));
  const auto alone = csv_rows(find("top.png", {"--calibration", file("camera.yaml"), "--field", "top"}).out);
  ASSERT_EQ(alone.size(), 1U);
  expect_pose(alone[0], pose, 0.05, 0.08);
}

TEST_F(CalibratedProgram, RefusesPicturesItIsNotFor) {
  const auto expect_refused = [](const Outcome& outcome, const std::string& line) {
    EXPECT_EQ(outcome.code, 2) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(line));
  };
  cv::imwrite(file("small.png"), cv::Mat(240, 320, CV_8U, cv::Scalar(128)));
  cv::imwrite(file("half.png"), cv::Mat(240, 640, CV_8U, cv::Scalar(128)));
  expect_refused(find("small.png", {"--calibration", file("camera.yaml")}),
                 "camera.yaml: is for frames of 640x480 (fields of 640x240), but the image is a frame of 320x240");
  expect_refused(find("half.png", {"--calibration", file("camera.yaml")}),
                 "is a frame of 640x240; for single fields say which one: top or bottom");
  expect_refused(find("train.png", {"--calibration", file("camera.yaml"), "--field", "bottom"}),
                 "is a bottom field of 640x480; it is as large as a whole frame");
  expect_refused(find("train.png", {}), "was trained in mm, and the pictures are in px");
  expect_refused(test::vsfind({"train", file("small.png"), "--roi", "9,9,99,99", "--calibration", file("camera.yaml"),
                               "-o", file("x.vsm")}),
                 "is for frames of 640x480");
}

}  // namespace
}  // namespace vsfind
