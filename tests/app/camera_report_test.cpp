#include "app/camera_report.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

namespace vsfind {
namespace {

CameraSizes fixed(int width, int height, std::vector<double> rates) {
  return {width, height, width, height, 0, 0, std::move(rates), false};
}

CameraDescription webcam() {
  CameraDescription camera;
  camera.uri = "v4l2:/dev/video0";
  camera.vendor = "Maker";
  camera.model = "Webcam 3";
  camera.serial = "A17";
  camera.address = "usb-0000:00:14.0-2";
  const std::vector<CameraSizes> sizes{fixed(640, 480, {30, 15}), fixed(1280, 720, {10})};
  camera.formats.push_back({"YUYV", "YUYV 4:2:2", true, sizes});
  camera.formats.push_back({"GREY", "8-bit Greyscale", true, sizes});
  camera.formats.push_back({"MJPG", "Motion-JPEG", false, {fixed(1920, 1080, {30})}});
  return camera;
}

TEST(CameraReport, IsALinePerCamera) {
  EXPECT_EQ(camera_line(webcam()),
            "v4l2:/dev/video0  Maker Webcam 3  serial A17  at usb-0000:00:14.0-2  YUYV,GREY 640x480, 1280x720 at 10 to "
            "30/s; 1 formats more, converted");
  CameraDescription gige;
  gige.uri = "gige:Aravis-1";
  gige.formats.push_back({"Mono8", "", true, {{16, 16, 2048, 1536, 8, 2, {0.5, 400.0}, true}}});
  gige.clock = Clock::device;
  gige.problem = "held by another program";
  EXPECT_EQ(camera_line(gige),
            "gige:Aravis-1  -  serial -  Mono8 16x16 to 2048x1536 at 0.5 to 400/s  timestamps (the camera's clock)  "
            "(held by another program)");
}

TEST(CameraReport, NamesTheFormatsThatAreThereWhereNoneIsDirect) {
  CameraDescription camera = webcam();
  camera.formats.erase(camera.formats.begin(), camera.formats.begin() + 2);
  EXPECT_THAT(camera_line(camera), testing::HasSubstr("MJPG 1920x1080 at 30/s"));
}

TEST(CameraReport, StaysALineWhateverACameraSaysOfItself) {
  CameraDescription camera = webcam();
  camera.model = "two\nlines\x1b[31m";
  EXPECT_EQ(camera_line(camera).find_first_of("\n\x1b"), std::string::npos);
  camera.serial = "\xff\xfe";
  EXPECT_TRUE(nlohmann::json::accept(cameras_json({camera})));
}

TEST(CameraReport, TellsProgramsEverything) {
  CameraDescription gige;
  gige.uri = "gige:Aravis-1";
  gige.formats.push_back({"Mono8", "", true, {{16, 16, 2048, 1536, 8, 2, {400.0, 0.5}, true}}});
  CameraDescription stamping = webcam();
  stamping.clock = Clock::monotonic;
  stamping.stamped_at = StampedAt::start;
  EXPECT_THAT(camera_line(stamping), testing::EndsWith("timestamps of the start of a frame (monotonic clock)"));
  const auto json = nlohmann::json::parse(cameras_json({stamping, gige}));
  ASSERT_EQ(json.size(), 2U);
  EXPECT_EQ(json[0]["uri"], "v4l2:/dev/video0");
  EXPECT_EQ(json[0]["serial"], "A17");
  EXPECT_EQ(json[0]["timestamps"]["clock"], "monotonic");
  EXPECT_EQ(json[0]["timestamps"]["of"], "start");
  EXPECT_EQ(json[0]["formats"].size(), 3U);
  EXPECT_EQ(json[0]["formats"][0]["sizes"][1]["width"], 1280);
  EXPECT_EQ(json[0]["formats"][0]["sizes"][0]["rates"], (std::vector<double>{30, 15}));
  EXPECT_EQ(json[0]["formats"][2]["direct"], false);
  EXPECT_EQ(json[1]["formats"][0]["sizes"][0]["height"]["max"], 1536);
  EXPECT_EQ(json[1]["formats"][0]["sizes"][0]["height"]["step"], 2);
  EXPECT_EQ(json[1]["formats"][0]["sizes"][0]["rates"]["min"], 0.5);
  EXPECT_EQ(nlohmann::json::parse(cameras_json({})), nlohmann::json::array());
}

}  // namespace
}  // namespace vsfind
