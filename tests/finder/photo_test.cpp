/// Photographs of Debian's opencv-doc package, resampled with exactly known pose: trained in one picture, found in
/// others, a test for each photograph.
#include "render/photo.h"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <string>

#include "acquisition/image_file.h"
#include "app/render/random.h"
#include "app/render/sensor.h"
#include "app/render/truth.h"
#include "finder/search.h"
#include "finder/train.h"

namespace vsfind {
namespace {

const std::string folder = "/usr/share/doc/opencv-doc/examples/data/";

struct Case {
  const char* file;
  int size;  ///< of the pattern, pixels of the reduced picture
};

void PrintTo(const Case& photo, std::ostream* out) { *out << photo.file; }

class PhotoPose : public ::testing::TestWithParam<Case> {
 protected:
  static constexpr double reduction = 2.3;  ///< photo pixels to a pixel of the training picture
  static constexpr int width = 260;
  static constexpr int height = 220;

  void SetUp() override {
    const std::string path = folder + GetParam().file;
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is missing: install Debian's opencv-doc";
    photo_ = std::make_unique<render::Photo>(load_image(path).view());
    const int w = static_cast<int>(photo_->width() / reduction);
    const int h = static_cast<int>(photo_->height() / reduction);
    const Eigen::Vector2d photo_centre((photo_->width() - 1) / 2.0, (photo_->height() - 1) / 2.0);
    const Pose at_rest{(w - 1) / 2.0 + 0.3, (h - 1) / 2.0 - 0.2, 0.0, 1.0, 1.0};
    const render::Exposure exposure = render::expose_photo(*photo_, photo_centre, reduction, at_rest, w, h);
    roi_ = render::richest_roi(exposure, GetParam().size, 8);
    centre_ = photo_centre + reduction * (render::roi_centre(roi_) - Eigen::Vector2d(at_rest.x, at_rest.y));
    training_ = render::develop(exposure, sensor(1));
  }

  static render::Sensor sensor(std::uint64_t seed) {
    render::Sensor sensor;
    sensor.noise = 2.0;
    sensor.seed = seed;
    return sensor;
  }

  /// The photo with the pattern's centre at the pose.
  [[nodiscard]] render::Picture picture(const Pose& pose, std::uint64_t seed) const {
    return render::develop(render::expose_photo(*photo_, centre_, reduction, pose, width, height), sensor(seed));
  }

  std::unique_ptr<render::Photo> photo_;
  render::Picture training_;
  Roi roi_;
  Eigen::Vector2d centre_;  ///< photo pixels of the pattern's centre
};

TEST_P(PhotoPose, IsFoundToATenthOfAPixel) {
  TrainOptions options;
  options.roi = roi_;
  options.angle_deg = {-45.0, 45.0};
  Finder finder({std::make_shared<const Pattern>(train(training_.view(), Mapping(), options))}, {});
  render::Random random(77);
  for (const double angle : {0.0, -31.7, 12.3, 44.5}) {
    const Pose truth{width / 2.0 + random.uniform(-20, 20), height / 2.0 + random.uniform(-15, 15), angle, 1.0, 1.0};
    const render::Picture scene = picture(truth, random.bits());
    const auto& matches = finder.find(scene.view(), Mapping()).front().matches;
    ASSERT_EQ(matches.size(), 1U) << angle;
    const Pose& pose = matches.front().pose;
    EXPECT_NEAR(pose.x, truth.x, 0.1) << angle;
    EXPECT_NEAR(pose.y, truth.y, 0.1) << angle;
    EXPECT_NEAR(pose.angle_deg, truth.angle_deg, 0.05) << angle;
  }
}

TEST_P(PhotoPose, IsFoundAtOtherSizes) {
  TrainOptions options;
  options.roi = roi_;
  options.angle_deg = {-20.0, 20.0};
  options.scale_x = options.scale_y = {0.85, 1.15};
  options.common_scale = true;
  Finder finder({std::make_shared<const Pattern>(train(training_.view(), Mapping(), options))}, {});
  render::Random random(78);
  for (const double scale : {0.87, 1.12}) {
    const Pose truth{width / 2.0 + random.uniform(-20, 20), height / 2.0 + random.uniform(-15, 15),
                     random.uniform(-18, 18), scale, scale};
    const render::Picture scene = picture(truth, random.bits());
    const auto& matches = finder.find(scene.view(), Mapping()).front().matches;
    ASSERT_EQ(matches.size(), 1U) << scale;
    const Pose& pose = matches.front().pose;
    EXPECT_NEAR(pose.x, truth.x, 0.1) << scale;
    EXPECT_NEAR(pose.y, truth.y, 0.1) << scale;
    EXPECT_NEAR(pose.angle_deg, truth.angle_deg, 0.05) << scale;
    EXPECT_NEAR(pose.scale_x, scale, 0.002);
  }
}

INSTANTIATE_TEST_SUITE_P(OpencvDoc, PhotoPose,
                         ::testing::Values(Case{"board.jpg", 80}, Case{"building.jpg", 80}, Case{"graf1.png", 90},
                                           Case{"leuvenA.jpg", 80}, Case{"box_in_scene.png", 64}, Case{"aero1.jpg", 80},
                                           Case{"home.jpg", 64}, Case{"stuff.jpg", 72}, Case{"fruits.jpg", 72},
                                           Case{"butterfly.jpg", 64}, Case{"rubberwhale1.png", 64},
                                           Case{"basketball1.png", 72}, Case{"pic1.png", 64}, Case{"pic2.png", 64},
                                           Case{"pic3.png", 64}, Case{"pic4.png", 64}, Case{"pic5.png", 64},
                                           Case{"pic6.png", 64}),
                         [](const auto& test) {
                           std::string label = test.param.file;
                           for (char& c : label) c = c == '.' ? '_' : c;
                           return label;
                         });

}  // namespace
}  // namespace vsfind
