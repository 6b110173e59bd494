#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "acquisition/errors.h"
#include "acquisition/recording.h"
#include "acquisition/source.h"
#include "tests/acquisition/support.h"

namespace vsfind {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

struct Reading {
  std::uint64_t frames = 0;
  std::string complaint;
};

/// Reads a sequence to its end, or until it complains.
Reading read_all(const std::string& path) {
  Reading reading;
  reading.complaint = test::complaint<IoError>([&] {
    const auto source = open_sequence(path);
    while (source->next()) ++reading.frames;
  });
  return reading;
}

TEST(DamagedRecording, RefusedOrReadUpToTheDamageInOneLine) {
  struct Case {
    std::string bytes;
    std::uint64_t frames;
    std::string said;  // behind "FILE: "
  };
  const std::string header = "YUV4MPEG2 W4 H2 F25:1 Cmono\n";
  const std::vector<Case> cases{
      {"", 0, "is empty, not a YUV4MPEG2 recording"},
      {"YUV4", 0, "not a YUV4MPEG2 recording: it begins with 'YUV4', not with 'YUV4MPEG2 '"},
      {"YUV4MPEG2 W4 H2", 0, "is cut off within its header"},
      {"\x89PNG\r\n", 0, "not a YUV4MPEG2 recording: it begins with '\\x89PNG\\x0d', not with 'YUV4MPEG2 '"},
      {std::string(5000, 'Y'), 0,
       "not a YUV4MPEG2 recording: it begins with '" + std::string(40, 'Y') + "…', not with 'YUV4MPEG2 '"},
      {"YUV4MPEG2 W4 H2 X" + std::string(5000, 'x') + "\n", 0, "its header is longer than the allowed 1024 bytes"},
      {"YUV4MPEG2 W65536 H16384 Cmono16\nFRAME\nabc", 0,
       "frame 0 is cut off: 2147483645 of its 2147483648 bytes are missing"},
      {"YUV4MPEG2 W-4 H2\nFRAME\n", 0, "bad width '-4' in the header: allowed are 1 to 65536"},
      {header, 0, ""},
      {header + "FRAME\n12345678", 1, ""},
      {header + "FRAME\n12345678FRAME\n12345", 1, "frame 1 is cut off: 3 of its 8 bytes are missing"},
      {header + "FRAME\n12345678FRAME\n", 1, "frame 1 is cut off: 8 of its 8 bytes are missing"},
      {header + "FRAME\n12345678FRAME X", 1, "frame 1 is cut off within its line: all of its 8 bytes are missing"},
      {header + "FRAME\n12345678F", 1, "frame 1 is cut off within its line: all of its 8 bytes are missing"},
      {header + "FRAME\n12345678garbage", 1,
       "frame 1 is damaged at byte 42: it begins with 'garbage', not with 'FRAME'"},
      {header + "FRAME\n123456789FRAME\n12345678", 1,
       "frame 1 is damaged at byte 42: it begins with '9FRAME', not with 'FRAME'"},
      {header + "FRAME\n12345678FRAME X" + std::string(2000, 'x') + "\n12345678", 1,
       "frame 1 is damaged at byte 42: its line is longer than the allowed 1024 bytes"},
      {header + "FRAME XVSFIND=1,2,xxxxx\n12345678", 0,
       "frame 0 is damaged at byte 28: bad parameter 'XVSFIND=1,2,xxxxx'"},
      {"YUV4MPEG2 W4 H2 C420\nFRAME\n12345678uv12345678", 1,
       "frame 1 is damaged at byte 39: it begins with '345678', not with 'FRAME'"},
      {"YUV4MPEG2 W4 H2 C420\nFRAME\n12345678uuv", 0, "frame 0 is cut off: 1 of its 12 bytes are missing"},
  };
  const test::TemporaryFolder folder;
  for (const Case& c : cases) {
    const std::string path = folder.file("bad.y4m");
    test::write_bytes(path, c.bytes);
    const Reading reading = read_all(path);
    EXPECT_EQ(reading.frames, c.frames) << c.said;
    EXPECT_EQ(reading.complaint, c.said.empty() ? "" : path + ": " + c.said);
  }
}

/// Ends at every byte there is: whole frames come first, and only a whole recording ends without a complaint.
TEST(DamagedRecording, CutOffAnywhere) {
  const test::TemporaryFolder folder;
  std::vector<std::size_t> ends;
  {
    SourceInfo info;
    info.width = 5;
    info.height = 3;
    info.bits = 12;
    RecordingWriter writer(folder.file("whole.y4m"), info);
    ends.push_back(writer.bytes());
    for (std::uint32_t i = 0; i < 3; ++i) {
      writer.append(test::Picture(5, 3, 12, i).view(), {});
      ends.push_back(writer.bytes());
    }
  }
  const std::string whole = test::read_bytes(folder.file("whole.y4m"));
  ASSERT_EQ(whole.size(), ends.back());
  const std::string path = folder.file("cut.y4m");
  for (std::size_t size = 0; size < whole.size(); ++size) {
    test::write_bytes(path, whole.substr(0, size));
    const Reading reading = read_all(path);
    std::uint64_t frames = 0;
    bool clean = size == ends[0];
    for (std::size_t i = 1; i < ends.size(); ++i) {
      frames += size >= ends[i] ? 1 : 0;
      clean = clean || size == ends[i];
    }
    EXPECT_EQ(reading.frames, frames) << "cut off at " << size;
    EXPECT_EQ(reading.complaint.empty(), clean) << "cut off at " << size << ": " << reading.complaint;
    if (!clean) {
      EXPECT_THAT(reading.complaint, AllOf(StartsWith(path + ": "), Not(HasSubstr("\n"))));
    }
  }
}

TEST(DamagedRecording, ASmallFileDoesNotGetMuchMemory) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers need the address space";
#endif
  const test::TemporaryFolder folder;
  test::write_bytes(folder.file("a.y4m"), "YUV4MPEG2 W65536 H16384 Cmono16\nFRAME\nabc");
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_AS, &before), 0);
  rlimit limit = before;
  limit.rlim_cur = rlim_t{1} << 31U;  // the frame alone would fill it
  ASSERT_EQ(::setrlimit(RLIMIT_AS, &limit), 0);
  const Reading reading = read_all(folder.file("a.y4m"));
  ::setrlimit(RLIMIT_AS, &before);
  EXPECT_THAT(reading.complaint, HasSubstr("frame 0 is cut off"));
}

TEST(DamagedRecording, ComplainsOnceAndThenEnds) {
  const test::TemporaryFolder folder;
  test::write_bytes(folder.file("a.y4m"), "YUV4MPEG2 W4 H2 Cmono\nFRAME\n1234");
  const auto source = open_y4m(folder.file("a.y4m"));
  EXPECT_THROW(static_cast<void>(source->next()), IoError);
  EXPECT_FALSE(source->next().has_value());
}

TEST(DamagedRecording, CutOffInAPipe) {
  const test::TemporaryFolder folder;
  const std::string pipe = folder.file("pipe");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  for (const auto& [bytes, said] :
       std::vector<std::pair<std::string, std::string>>{{"YUV4MPEG2 W4 H2 C420\nFRAME\n12345678uuvvFRAME\n1234",
                                                         "frame 1 is cut off: 8 of its 12 bytes are missing"},
                                                        {"YUV4MPEG2 W4 H2 C420\nFRAME\n12345678uuvvFRAME\n12345678u",
                                                         "frame 1 is cut off: 3 of its 12 bytes are missing"}}) {
    // The pipe holds so few bytes without a reader that writes, once both ends are open.
    std::thread writer([&, text = bytes] { test::write_bytes(pipe, text); });
    const Reading reading = read_all(pipe);
    writer.join();
    EXPECT_EQ(reading.frames, 1U);
    EXPECT_EQ(reading.complaint, pipe + ": " + said);
  }
}

TEST(DamagedRecording, PathsThatCannotBeOpened) {
  const test::TemporaryFolder folder;
  const std::string missing = folder.file("missing.y4m");
  EXPECT_EQ(read_all(missing).complaint, missing + ": cannot be opened: No such file or directory");
  EXPECT_EQ(read_all("").complaint, "'': cannot be opened: No such file or directory");
  EXPECT_EQ(test::complaint<IoError>([&] { static_cast<void>(open_y4m(folder.path())); }),
            folder.path() + ": cannot be opened: Is a directory");
  const std::string secret = folder.file("secret.y4m");
  test::write_bytes(secret, "YUV4MPEG2 W4 H2\n");
  ASSERT_EQ(::chmod(secret.c_str(), 0), 0);
  if (::geteuid() != 0) {  // root may read everything
    EXPECT_EQ(read_all(secret).complaint, secret + ": cannot be opened: Permission denied");
  }
}

TEST(FullDisk, IsReportedWithTheFilesName) {
  SourceInfo info;
  info.width = 4;
  info.height = 2;
  EXPECT_EQ(test::complaint<IoError>([&] { RecordingWriter("/dev/full", info); }),
            "/dev/full: the header cannot be written: No space left on device");
  EXPECT_EQ(test::complaint<IoError>([&] { RecordingWriter("/nonexistent/a.y4m", info); }),
            "/nonexistent/a.y4m: cannot be created: No such file or directory");
}

TEST(FullDisk, LeavesWholeFrames) {
  const test::TemporaryFolder folder;
  const std::string path = folder.file("a.y4m");
  SourceInfo info;
  info.width = 100;
  info.height = 100;
  // A limit on the size of files stands for the full disk: a write is then cut short, and the next one fails.
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  rlimit limit = before;
  limit.rlim_cur = 35000;
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
  RecordingWriter writer(path, info);
  const test::Picture picture(100, 100, 8, 1);
  const std::string said = test::complaint<IoError>([&] {
    for (int i = 0; i < 10; ++i) writer.append(picture.view(), {});
  });
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(said, path + ": frame 3 cannot be written: File too large");
  EXPECT_EQ(writer.frames(), 3U);
  const Reading reading = read_all(path);
  EXPECT_EQ(reading.frames, 3U);
  EXPECT_EQ(reading.complaint, "");
  // Where there is room again, the recording goes on behind its last whole frame.
  writer.append(picture.view(), {});
  EXPECT_EQ(read_all(path).frames, 4U);
}

}  // namespace
}  // namespace vsfind
