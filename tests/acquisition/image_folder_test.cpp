#include "acquisition/image_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "acquisition/errors.h"
#include "tests/acquisition/support.h"

namespace vsfind {
namespace {

/// What is logged while it lives.
class LogCapture {
 public:
  LogCapture() : before_(spdlog::default_logger()) {
    auto sink = std::make_shared<spdlog::sinks::ostream_sink_mt>(text_);
    auto logger = std::make_shared<spdlog::logger>("test", sink);
    logger->set_pattern("%l %v");
    spdlog::set_default_logger(logger);
  }
  LogCapture(const LogCapture&) = delete;
  LogCapture& operator=(const LogCapture&) = delete;
  ~LogCapture() { spdlog::set_default_logger(before_); }
  [[nodiscard]] std::string text() const { return text_.str(); }

 private:
  std::ostringstream text_;
  std::shared_ptr<spdlog::logger> before_;
};

void write_grey(const std::string& path, int width, int height, int type, int grey) {
  ASSERT_TRUE(cv::imwrite(path, cv::Mat(height, width, type, cv::Scalar::all(grey))));
}

TEST(ImageFolder, GivesItsImagesInNameOrder) {
  const test::TemporaryFolder folder;
  write_grey(folder.file("b2.png"), 6, 4, CV_8UC1, 30);
  write_grey(folder.file("a9.PGM.pgm"), 5, 3, CV_8UC1, 20);
  write_grey(folder.file("a10.tiff"), 4, 2, CV_16UC1, 1000);
  write_grey(folder.file("b10.bmp"), 7, 5, CV_8UC3, 25);
  write_grey(folder.file("Z.jpg"), 8, 8, CV_8UC1, 5);
  write_grey(folder.file(".hidden.png"), 9, 9, CV_8UC1, 99);
  test::write_bytes(folder.file("notes.txt"), "no image");
  std::filesystem::create_directory(folder.file("c.png"));

  const auto source = open_sequence(folder.path());
  EXPECT_EQ(source->info().name, folder.path());
  EXPECT_EQ(source->info().frames, 5U);
  EXPECT_EQ(source->info().width, 8);
  EXPECT_EQ(source->info().height, 8);
  EXPECT_EQ(source->info().bits, 8);
  EXPECT_EQ(source->info().order, FieldOrder::unknown);
  EXPECT_FALSE(source->info().live);
  const std::vector<std::array<int, 4>> expected{
      {8, 8, 8, 5}, {4, 2, 16, 1000}, {5, 3, 8, 20}, {7, 5, 8, 25}, {6, 4, 8, 30}};
  for (std::uint64_t i = 0; i < expected.size(); ++i) {
    const auto frame = source->next();
    ASSERT_TRUE(frame.has_value());
    const auto [width, height, bits, grey] = expected[i];
    EXPECT_EQ(frame->image().width, width);
    EXPECT_EQ(frame->image().height, height);
    EXPECT_EQ(frame->image().bits, bits);
    EXPECT_NEAR(frame->image().at(width - 1, height - 1), grey, 1);
    EXPECT_EQ(frame->info().sequence, i);
    EXPECT_EQ(frame->info().clock, Clock::none);
    EXPECT_EQ(frame->info().timestamp_ns, 0);
    EXPECT_GT(frame->info().arrival_ns, 0);
    EXPECT_EQ(frame->info().field, Field::frame);
    EXPECT_EQ(frame->info().status, FrameStatus::good);
  }
  EXPECT_FALSE(source->next().has_value());
}

TEST(ImageFolder, ADamagedImageIsACorruptFrameAndTheRestFollows) {
  const test::TemporaryFolder folder;
  for (const char* name : {"0.png", "1.png", "2.png", "3.png"}) write_grey(folder.file(name), 20, 10, CV_8UC1, 7);
  const std::string whole = test::read_bytes(folder.file("1.png"));
  test::write_bytes(folder.file("1.png"), whole.substr(0, whole.size() / 2));
  const auto source = open_image_folder(folder.path());
  std::filesystem::remove(folder.file("2.png"));

  const LogCapture log;
  testing::internal::CaptureStderr();
  std::vector<FrameStatus> statuses;
  while (const auto frame = source->next()) {
    EXPECT_EQ(frame->info().sequence, statuses.size());
    EXPECT_EQ(frame->image().empty(), frame->info().status == FrameStatus::corrupt);
    statuses.push_back(frame->info().status);
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  using enum FrameStatus;
  EXPECT_EQ(statuses, (std::vector<FrameStatus>{good, corrupt, corrupt, good}));
  EXPECT_EQ(log.text(), "warning " + folder.file("1.png") + ": is cut off\nwarning " + folder.file("2.png") +
                            ": cannot be opened: No such file or directory\n");
}

TEST(ImageFolder, ADamagedFirstImageIsNamedOnce) {
  const test::TemporaryFolder folder;
  test::write_bytes(folder.file("0.png"), "no image");
  write_grey(folder.file("1.png"), 20, 10, CV_8UC1, 7);
  const LogCapture log;
  const auto source = open_image_folder(folder.path());
  EXPECT_EQ(source->info().width, 0);
  EXPECT_EQ(source->next()->info().status, FrameStatus::corrupt);
  EXPECT_EQ(source->next()->info().status, FrameStatus::good);
  EXPECT_FALSE(source->next().has_value());
  EXPECT_EQ(log.text(), "warning " + folder.file("0.png") +
                            ": is no image that can be read: PNG, JPEG, TIFF, BMP and PNM (PGM, PPM, PBM) can\n");
}

TEST(ImageFolder, WithoutImagesIsRefused) {
  const test::TemporaryFolder folder;
  const std::string said =
      folder.path() + ": holds no image: a name must end in .png .pgm .tif .tiff .bmp .jpg .jpeg .pnm .ppm";
  EXPECT_EQ(test::complaint<IoError>([&] { static_cast<void>(open_sequence(folder.path())); }), said);
  test::write_bytes(folder.file("notes.txt"), "no image");
  EXPECT_EQ(test::complaint<IoError>([&] { static_cast<void>(open_sequence(folder.path())); }), said);
  EXPECT_EQ(test::complaint<IoError>([&] { static_cast<void>(open_image_folder("/nonexistent")); }),
            "/nonexistent: cannot be read: No such file or directory");
}

TEST(ImageFolder, FramesOutliveTheirSourceAndStopEndsIt) {
  const test::TemporaryFolder folder;
  for (const char* name : {"0.png", "1.png", "2.png"}) write_grey(folder.file(name), 20, 10, CV_8UC1, 7);
  std::vector<Frame> frames;
  {
    const auto source = open_image_folder(folder.path());
    frames.push_back(*source->next());
    frames.push_back(*source->next());
    source->stop();
    EXPECT_FALSE(source->next().has_value());
  }
  EXPECT_EQ(frames[1].image().at(19, 9), 7);
  std::thread([taken = std::move(frames)]() mutable { taken.clear(); }).join();
}

}  // namespace
}  // namespace vsfind
