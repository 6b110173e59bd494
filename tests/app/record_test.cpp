/// `record`: nothing is dropped, whatever ends it.

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <functional>
#include <thread>

#include "acquisition/buffer_pool.h"
#include "acquisition/errors.h"
#include "acquisition/recording.h"
#include "app/record_run.h"
#include "tests/app/scene.h"

namespace vsfind {
namespace {

using test::Outcome;
using testing::HasSubstr;

constexpr int width = 64;
constexpr int height = 48;

/// A camera with eight buffers whose frames tell their numbers in every pixel, and which does something before each.
class NumberedSource final : public FrameSource {
 public:
  explicit NumberedSource(std::function<void(std::uint64_t, NumberedSource&)> before = {})
      : pool_(BufferPool::create(8)), before_(std::move(before)) {
    info_.name = "numbered";
    info_.width = width;
    info_.height = height;
    info_.live = true;
  }
  [[nodiscard]] const SourceInfo& info() const override { return info_; }
  std::optional<Frame> next() override {
    if (before_) before_(given, *this);
    auto lease = pool_->acquire(width * height);
    if (!lease) return std::nullopt;
    std::memset(lease->data(), static_cast<int>(given % 251), width * height);
    FrameInfo frame;
    frame.sequence = given * step;
    frame.arrival_ns = static_cast<std::int64_t>(given) * 1'000'000;
    frame.status = given == bad ? FrameStatus::corrupt : FrameStatus::good;
    ++given;
    return std::move(*lease).to_frame({lease->data(), width, info_.height, width, 8}, frame);
  }
  void stop() noexcept override { pool_->stop(); }

  SourceInfo info_;
  std::uint64_t given = 0;
  std::uint64_t step = 1;
  std::uint64_t bad = ~std::uint64_t{0};

 private:
  std::shared_ptr<BufferPool> pool_;
  std::function<void(std::uint64_t, NumberedSource&)> before_;
};

/// Checks that a recording holds the frames 0 … count-1, and gives back how many of them are bad.
std::uint64_t bad_of(const std::string& path, std::uint64_t count, std::uint64_t step = 1) {
  const auto source = open_y4m(path);
  std::uint64_t found = 0;
  std::uint64_t bad = 0;
  while (const auto frame = source->next()) {
    EXPECT_EQ(frame->info().sequence, found * step);
    EXPECT_EQ(frame->image().at(width - 1, height - 1), static_cast<int>(found % 251));
    if (frame->info().status != FrameStatus::good) ++bad;
    ++found;
  }
  EXPECT_EQ(found, count);
  return bad;
}

class Record : public testing::Test {
 protected:
  Recorded run(FrameSource& source, const RecordLimits& limits = {}) {
    SignalWatcher signals;
    return record(source, path_, limits, signals, [this](std::uint64_t done) { progress_ = done; });
  }
  test::TemporaryFolder folder_;
  std::string path_ = folder_ / "line.y4m";
  std::uint64_t progress_ = 0;
};

TEST_F(Record, KeepsEveryFrameItsNumberAndItsState) {
  NumberedSource source;
  source.step = 3;
  source.bad = 7;
  const Recorded recorded = run(source, {100, 0});
  EXPECT_FALSE(recorded.error);
  EXPECT_EQ(recorded.frames, 100U);
  EXPECT_EQ(recorded.bad, 1U);
  EXPECT_EQ(recorded.gaps, 99U * 2) << "the camera counted frames that it did not give";
  EXPECT_EQ(recorded.bytes, std::filesystem::file_size(path_));
  EXPECT_NEAR(recorded.seconds, 0.099, 1e-9);
  EXPECT_EQ(progress_, 100U);
  EXPECT_EQ(bad_of(path_, 100, 3), 1U);
}

TEST_F(Record, WaitsForASlowDisk) {
  ASSERT_EQ(::mkfifo(path_.c_str(), 0600), 0);
  const std::string copy = folder_ / "copy.y4m";
  std::thread slow([&] {
    const int from = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC);
    std::string all;
    std::string bytes(16384, '\0');
    for (ssize_t count = 0; (count = ::read(from, bytes.data(), bytes.size())) > 0;) {
      all.append(bytes, 0, static_cast<std::size_t>(count));
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    ::close(from);
    test::write_file(copy, all);
  });
  NumberedSource source;
  const Recorded recorded = run(source, {300, 0});
  slow.join();
  EXPECT_FALSE(recorded.error);
  EXPECT_EQ(bad_of(copy, 300), 0U);
}

TEST_F(Record, EndsAfterItsTime) {
  NumberedSource source(
      [](std::uint64_t, NumberedSource&) { std::this_thread::sleep_for(std::chrono::milliseconds(1)); });
  const Recorded recorded = run(source, {0, 0.05});
  EXPECT_FALSE(recorded.error);
  EXPECT_GE(recorded.frames, 1U);
  EXPECT_EQ(bad_of(path_, recorded.frames), 0U);
}

TEST_F(Record, EndsAtASignalWithAllThatWasCaptured) {
  NumberedSource source([](std::uint64_t number, NumberedSource&) {
    if (number == 20) ::kill(::getpid(), SIGTERM);
  });
  const Recorded recorded = run(source);
  EXPECT_FALSE(recorded.error);
  EXPECT_GE(recorded.frames, 20U);
  EXPECT_EQ(recorded.frames, source.given);
  EXPECT_EQ(bad_of(path_, recorded.frames), 0U);
}

TEST_F(Record, KeepsWhatCameBeforeTheCameraFailed) {
  NumberedSource source([](std::uint64_t number, NumberedSource&) {
    if (number == 30) throw CameraError("numbered: gone");
  });
  const Recorded recorded = run(source);
  ASSERT_TRUE(recorded.error);
  EXPECT_THROW(std::rethrow_exception(recorded.error), CameraError);
  EXPECT_EQ(recorded.frames, 30U);
  EXPECT_EQ(bad_of(path_, 30), 0U);
}

TEST_F(Record, GoesOnInAnotherFileWhereTheCameraReturnsWithAnotherSize) {
  NumberedSource source([](std::uint64_t number, NumberedSource& self) {
    if (number == 10) self.info_.height = height / 2;
    if (number == 14) self.info_.height = height;
    if (number == 20) self.stop();
  });
  const Recorded recorded = run(source);
  EXPECT_FALSE(recorded.error);
  EXPECT_EQ(recorded.frames, 20U);
  EXPECT_EQ(bad_of(path_, 10), 0U);
  std::uintmax_t bytes = std::filesystem::file_size(path_);
  std::uint64_t number = 10;
  for (const auto& [name, count] : {std::pair{"line-2.y4m", 4}, {"line-3.y4m", 6}}) {
    const auto source_of_file = open_y4m(folder_ / name);
    EXPECT_EQ(source_of_file->info().height, count == 4 ? height / 2 : height);
    int found = 0;
    while (const auto frame = source_of_file->next()) {
      EXPECT_EQ(frame->info().sequence, number++);
      ++found;
    }
    EXPECT_EQ(found, count) << name;
    bytes += std::filesystem::file_size(folder_ / name);
  }
  EXPECT_EQ(recorded.bytes, bytes);
}

TEST_F(Record, MakesNoFileWithoutAFrame) {
  NumberedSource source;
  source.stop();
  EXPECT_FALSE(run(source).error);
  EXPECT_FALSE(std::filesystem::exists(path_));
}

/// The program itself, on a recording in place of a camera.
class RecordCommand : public testing::Test {
 protected:
  void SetUp() override {
    for (int i = 0; i < 12; ++i) frames_.push_back(test::scene(60 + 7 * i, 50 + 5 * i));
    test::write_y4m(folder_ / "line.y4m", frames_, 't', " A59:54");
  }
  [[nodiscard]] Outcome command(const std::vector<std::string>& more, const std::string& source = "line.y4m") const {
    std::vector<std::string> arguments{"record", "--source", "file:" + folder_ / source};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return test::vsfind(arguments);
  }
  test::TemporaryFolder folder_;
  std::vector<cv::Mat> frames_;
};

TEST_F(RecordCommand, CopiesARecordingLosslessly) {
  const Outcome outcome = command({"-o", folder_ / "copy.y4m"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("12 frames in"));
  const auto from = open_y4m(folder_ / "line.y4m");
  const auto to = open_y4m(folder_ / "copy.y4m");
  EXPECT_EQ(to->info().order, FieldOrder::top_first);
  EXPECT_EQ(to->info().pixel_aspect.numerator, 59);
  for (int i = 0; i < 12; ++i) {
    const auto a = from->next();
    const auto b = to->next();
    ASSERT_TRUE(a && b);
    EXPECT_EQ(a->info().timestamp_ns, b->info().timestamp_ns);
    EXPECT_EQ(std::memcmp(a->image().data, b->image().data, test::scene_width * test::scene_height), 0) << i;
  }
  EXPECT_FALSE(to->next());
}

TEST_F(RecordCommand, StopsAfterItsFrames) {
  EXPECT_EQ(command({"-o", folder_ / "copy.y4m", "--frames", "5", "-q"}).code, 0);
  const auto copy = open_y4m(folder_ / "copy.y4m");
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(copy->next());
  EXPECT_FALSE(copy->next());
}

TEST_F(RecordCommand, TellsOfAFullDiskInOneLine) {
  const Outcome outcome = command({"-o", "/dev/full", "-q"});
  EXPECT_EQ(outcome.code, 3);
  EXPECT_EQ(test::lines_of(outcome.err).size(), 1U) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("/dev/full"));
  EXPECT_THAT(outcome.err, HasSubstr("No space left on device"));
}

TEST_F(RecordCommand, RefusesWhatCannotBe) {
  const auto refused = [&](const std::vector<std::string>& arguments, const std::string& why, int code = 2) {
    const Outcome outcome = test::vsfind(arguments);
    EXPECT_EQ(outcome.code, code) << outcome.err;
    EXPECT_EQ(test::lines_of(outcome.err).size(), 1U) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(why));
  };
  const std::string line = folder_ / "line.y4m";
  const std::string to = folder_ / "to.y4m";
  refused({"record", "-o", to}, "--source is needed");
  refused({"record", "--source", "file:" + line}, "-o FILE.y4m is needed");
  refused({"record", "--source", "file:" + line, "-o", line}, "over itself");
  refused({"record", "--source", line, "-o", to}, "allowed: v4l2:");
  refused({"record", "--source", "file:" + line, "-o", to, "--frames", "0"}, "--frames");
  refused({"record", "--source", "file:" + line, "-o", to, "--seconds", "soon"}, "--seconds");
  refused({"record", "--source", "file:" + folder_ / "none.y4m", "-o", to}, "none.y4m", 3);
  refused({"record", "--source", "file:" + line, "-o", folder_ / "no/such/folder.y4m", "-q"}, "folder.y4m", 3);
  EXPECT_TRUE(std::filesystem::exists(line));
  EXPECT_FALSE(std::filesystem::exists(to));
}

TEST_F(RecordCommand, FinishesAtASignal) {
  const std::string pipe = folder_ / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const std::string bytes = test::read_file(folder_ / "line.y4m");
  test::Process process({"record", "--source", "file:" + pipe, "-o", folder_ / "copy.y4m"});
  const int camera = ::open(pipe.c_str(), O_WRONLY | O_CLOEXEC);
  ASSERT_EQ(::write(camera, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  // Until the last of the frames is in the file; the source then waits for more.
  constexpr std::uintmax_t all = 12 * test::scene_width * test::scene_height;
  std::error_code ignored;
  for (int i = 0; i < 3000; ++i) {
    if (std::filesystem::exists(folder_ / "copy.y4m", ignored) &&
        std::filesystem::file_size(folder_ / "copy.y4m") > all)
      break;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  process.kill(SIGTERM);
  const Outcome outcome = process.wait();
  ::close(camera);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("12 frames in"));
}

}  // namespace
}  // namespace vsfind
