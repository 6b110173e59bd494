// What GLib and Aravis complain of comes as lines of our own log.

#include <glib.h>
#include <gmock/gmock.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <sstream>

#include "acquisition/camera.h"

namespace vsfind {
namespace {

class CameraLibraryLog : public testing::Test {
 protected:
  void SetUp() override {
    auto logger = std::make_shared<spdlog::logger>("test", std::make_shared<spdlog::sinks::ostream_sink_mt>(heard_));
    logger->set_pattern("%l: %v");
    logger->set_level(spdlog::level::info);
    spdlog::set_default_logger(logger);
    log_camera_libraries();
  }
  void TearDown() override {
    g_log_set_default_handler(g_log_default_handler, nullptr);
    spdlog::set_default_logger(before_);
  }

  std::shared_ptr<spdlog::logger> before_ = spdlog::default_logger();
  std::ostringstream heard_;
};

TEST_F(CameraLibraryLog, AComplaintIsOneLineAtLevelInfo) {
  testing::internal::CaptureStderr();
  g_log("GLib", G_LOG_LEVEL_CRITICAL, "an assertion\nof %d lines", 2);
  g_log(nullptr, G_LOG_LEVEL_WARNING, "who says it?");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(heard_.str(),
            "info: camera library: GLib: an assertion of 2 lines\ninfo: camera library: GLib: who says it?\n");
}

TEST_F(CameraLibraryLog, WithoutVerboseItIsNotHeard) {
  spdlog::default_logger()->set_level(spdlog::level::warn);
  testing::internal::CaptureStderr();
  g_log("Aravis", G_LOG_LEVEL_CRITICAL, "nothing that a user can mend");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(heard_.str(), "");
}

}  // namespace
}  // namespace vsfind
