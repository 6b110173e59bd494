#include "acquisition/recording.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <future>
#include <limits>
#include <optional>
#include <thread>
#include <vector>

#include "acquisition/buffer_pool.h"
#include "acquisition/byte_reader.h"
#include "acquisition/errors.h"
#include "tests/acquisition/support.h"

namespace vsfind {
namespace {

using namespace std::chrono_literals;
using test::Picture;
using test::same_pixels;

SourceInfo shape(int width, int height, int bits) {
  SourceInfo info;
  info.width = width;
  info.height = height;
  info.bits = bits;
  return info;
}

FrameInfo info_of(std::uint64_t sequence, FrameStatus status = FrameStatus::good, Field field = Field::frame) {
  FrameInfo info;
  info.sequence = sequence;
  info.timestamp_ns = static_cast<std::int64_t>(sequence) * 20'000'003 - 7;
  info.clock = Clock::monotonic;
  info.stamped_at = StampedAt::end;
  info.status = status;
  info.field = field;
  info.order = FieldOrder::top_first;
  return info;
}

void expect_same(const FrameInfo& read, const FrameInfo& written) {
  EXPECT_EQ(read.sequence, written.sequence);
  EXPECT_EQ(read.timestamp_ns, written.timestamp_ns);
  EXPECT_EQ(read.clock, written.clock);
  EXPECT_EQ(read.stamped_at, written.stamped_at);
  EXPECT_EQ(read.field, written.field);
  EXPECT_EQ(read.order, written.order);
  EXPECT_EQ(read.status, written.status);
}

struct Form {
  int width;
  int height;
  int bits;
  int padding;
};
class RoundTrip : public testing::TestWithParam<Form> {};

INSTANTIATE_TEST_SUITE_P(, RoundTrip,
                         testing::Values(Form{640, 480, 8, 0}, Form{641, 479, 8, 0}, Form{31, 17, 8, 9},
                                         Form{33, 18, 9, 0}, Form{64, 48, 10, 0}, Form{63, 47, 11, 2},
                                         Form{65, 3, 12, 0}, Form{8, 8, 13, 6}, Form{9, 5, 14, 0}, Form{7, 6, 15, 4},
                                         Form{320, 240, 16, 0}, Form{1, 1, 8, 0}, Form{1, 1, 16, 0}),
                         [](const auto& tested) {
                           return fmt::format("{}x{}_{}bits_{}padding", tested.param.width, tested.param.height,
                                              tested.param.bits, tested.param.padding);
                         });

TEST_P(RoundTrip, KeepsPixelsAndMetadata) {
  const auto [width, height, bits, padding] = GetParam();
  const test::TemporaryFolder folder;
  SourceInfo info = shape(width, height, bits);
  info.order = FieldOrder::bottom_first;
  info.pixel_aspect = {10, 11};
  info.frame_rate = {30000, 1001};
  const std::vector<std::uint64_t> sequences{3, 4, 7, 65536, std::numeric_limits<std::uint64_t>::max()};
  RecordingWriter writer(folder.file("a.y4m"), info);
  for (const std::uint64_t sequence : sequences)
    writer.append(Picture(width, height, bits, static_cast<std::uint32_t>(sequence), padding).view(),
                  info_of(sequence));
  writer.close();
  EXPECT_EQ(writer.frames(), sequences.size());
  EXPECT_EQ(writer.bytes(), std::filesystem::file_size(folder.file("a.y4m")));

  const auto source = open_y4m(folder.file("a.y4m"));
  EXPECT_EQ(source->info().name, folder.file("a.y4m"));
  EXPECT_EQ(source->info().width, width);
  EXPECT_EQ(source->info().height, height);
  EXPECT_EQ(source->info().bits, bits);
  EXPECT_EQ(source->info().order, FieldOrder::bottom_first);
  EXPECT_DOUBLE_EQ(source->info().pixel_aspect.value(), 10.0 / 11.0);
  EXPECT_DOUBLE_EQ(source->info().frame_rate.value(), 30000.0 / 1001.0);
  EXPECT_EQ(source->info().frames, sequences.size());
  EXPECT_FALSE(source->info().live);
  for (const std::uint64_t sequence : sequences) {
    const std::optional<Frame> frame = source->next();
    ASSERT_TRUE(frame.has_value());
    expect_same(frame->info(), info_of(sequence));
    EXPECT_TRUE(same_pixels(frame->image(), Picture(width, height, bits, static_cast<std::uint32_t>(sequence)).view()));
  }
  EXPECT_FALSE(source->next().has_value());
  EXPECT_FALSE(source->next().has_value());
}

TEST(Recording, TheArrivalIsWhenTheFrameWasRead) {
  const test::TemporaryFolder folder;
  {
    RecordingWriter writer(folder.file("a.y4m"), shape(4, 4, 8));
    writer.append(Picture(4, 4, 8, 0).view(), info_of(0));
  }
  const auto now = [] { return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count(); };
  const auto before = now();
  const auto frame = open_y4m(folder.file("a.y4m"))->next();
  EXPECT_GE(frame->info().arrival_ns, before);
  EXPECT_LE(frame->info().arrival_ns, now());
}

TEST(Recording, SingleFieldsComeBackAlone) {
  for (const int height : {8, 9}) {
    for (const int bits : {8, 12}) {
      const test::TemporaryFolder folder;
      const Picture whole(10, height, bits, 1);
      const Picture other(10, height, bits, 2);
      const ImageView top = field_view(other.view(), Field::top);
      const ImageView bottom = field_view(other.view(), Field::bottom);
      {
        RecordingWriter writer(folder.file("a.y4m"), shape(10, height, bits));
        writer.append(top, info_of(0, FrameStatus::good, Field::top));
        writer.append(whole.view(), info_of(1));
        writer.append(bottom, info_of(2, FrameStatus::good, Field::bottom));
      }
      const auto source = open_y4m(folder.file("a.y4m"));
      std::vector<Frame> frames;
      while (auto frame = source->next()) frames.push_back(std::move(*frame));
      ASSERT_EQ(frames.size(), 3U);
      EXPECT_EQ(frames[0].info().field, Field::top);
      EXPECT_TRUE(same_pixels(frames[0].image(), top));
      EXPECT_EQ(frames[1].info().field, Field::frame);
      EXPECT_TRUE(same_pixels(frames[1].image(), whole.view()));
      EXPECT_EQ(frames[2].info().field, Field::bottom);
      EXPECT_TRUE(same_pixels(frames[2].image(), bottom));

      // Other programs see the field's rows twice.
      const std::string bytes = test::read_bytes(folder.file("a.y4m"));
      const std::size_t pixels = bytes.find('\n', bytes.find("FRAME")) + 1;
      const std::size_t row = 10U * (bits > 8 ? 2U : 1U);
      EXPECT_EQ(bytes.substr(pixels, row), bytes.substr(pixels + row, row));
      EXPECT_EQ(bytes.substr(bytes.size() - row), bytes.substr(bytes.size() - 2 * row, row));
    }
  }
}

TEST(Recording, BadFramesKeepTheirStatus) {
  const test::TemporaryFolder folder;
  const Picture good(6, 4, 8, 1);
  const Picture part(6, 2, 8, 2);
  const Picture large(9, 9, 8, 3);
  const Picture deep(6, 4, 16, 4);
  {
    RecordingWriter writer(folder.file("a.y4m"), shape(6, 4, 8));
    writer.append(ImageView{}, info_of(0, FrameStatus::corrupt));
    writer.append(part.view(), info_of(1, FrameStatus::incomplete));
    writer.append(large.view(), info_of(2, FrameStatus::incomplete, Field::top));
    writer.append(deep.view(), info_of(3, FrameStatus::corrupt));
    writer.append(ImageView{}, info_of(4, FrameStatus::incomplete, Field::bottom));
    writer.append(good.view(), info_of(5));
  }
  const auto source = open_y4m(folder.file("a.y4m"));
  std::vector<Frame> frames;
  while (auto frame = source->next()) frames.push_back(std::move(*frame));
  ASSERT_EQ(frames.size(), 6U);
  expect_same(frames[0].info(), info_of(0, FrameStatus::corrupt));
  EXPECT_TRUE(frames[0].image().empty());
  expect_same(frames[1].info(), info_of(1, FrameStatus::incomplete));
  ASSERT_EQ(frames[1].image().height, 4);
  EXPECT_EQ(frames[1].image().at(5, 1), part.view().at(5, 1));
  EXPECT_EQ(frames[1].image().at(5, 2), 0);
  expect_same(frames[2].info(), info_of(2, FrameStatus::incomplete, Field::top));
  EXPECT_EQ(frames[2].image().at(5, 1), large.view().at(5, 1));
  expect_same(frames[3].info(), info_of(3, FrameStatus::corrupt));
  EXPECT_EQ(frames[3].image().at(0, 0), 0);
  expect_same(frames[4].info(), info_of(4, FrameStatus::incomplete, Field::bottom));
  EXPECT_TRUE(same_pixels(frames[5].image(), good.view()));
}

TEST(Recording, GoodFramesOfAnotherFormAreRefused) {
  const test::TemporaryFolder folder;
  const std::string path = folder.file("a.y4m");
  RecordingWriter writer(path, shape(6, 4, 8));
  const auto said = [&](const Picture& picture, Field field) {
    return test::complaint<UsageError>([&] { writer.append(picture.view(), info_of(0, FrameStatus::good, field)); });
  };
  EXPECT_EQ(said({6, 4, 8, 1}, Field::frame), "");
  EXPECT_EQ(said({6, 2, 8, 1}, Field::bottom), "");
  EXPECT_EQ(said({6, 5, 8, 1}, Field::frame),
            path + ": frame 2 (frame) has 6x5 pixels of 8 bits, the recording 6x4 of 8 bits: they must agree");
  EXPECT_NE(said({6, 4, 8, 1}, Field::top), "");
  EXPECT_NE(said({7, 4, 8, 1}, Field::frame), "");
  EXPECT_NE(said({6, 4, 9, 1}, Field::frame), "");
  EXPECT_NE(test::complaint<UsageError>([&] { writer.append(ImageView{}, info_of(0)); }), "");
  EXPECT_EQ(writer.frames(), 2U);
  writer.close();
  writer.close();
  EXPECT_EQ(open_y4m(path)->info().frames, 2U);
  EXPECT_THAT(test::complaint<IoError>([&] { writer.append(Picture(6, 4, 8, 1).view(), info_of(0)); }),
              testing::HasSubstr("is closed"));
}

TEST(Recording, FormsThatCannotBeWrittenAreRefused) {
  const test::TemporaryFolder folder;
  for (const auto& [width, height, bits] : {std::array{0, 4, 8}, std::array{4, -1, 8}, std::array{65537, 4, 8},
                                            std::array{65536, 65536, 8}, std::array{4, 4, 7}, std::array{4, 4, 17}}) {
    EXPECT_THROW(RecordingWriter(folder.file("a.y4m"), shape(width, height, bits)), UsageError);
    EXPECT_FALSE(std::filesystem::exists(folder.file("a.y4m")));
  }
}

TEST(Recording, OfOtherProgramsCountsFramesAndTime) {
  const test::TemporaryFolder folder;
  test::write_bytes(folder.file("a.y4m"),
                    "YUV4MPEG2 W2 H1 F30000:1001 Cmono It\nFRAME\nabFRAME Xwhatever\ncdFRAME\nef");
  const auto source = open_y4m(folder.file("a.y4m"));
  EXPECT_FALSE(source->info().frames.has_value());  // lines of different length
  const std::vector<std::int64_t> times{0, 33'366'666, 66'733'333};
  for (std::uint64_t i = 0; i < 3; ++i) {
    const auto frame = source->next();
    ASSERT_TRUE(frame.has_value());
    EXPECT_EQ(frame->info().sequence, i);
    EXPECT_EQ(frame->info().timestamp_ns, times[i]);
    EXPECT_EQ(frame->info().clock, Clock::recording);
    EXPECT_EQ(frame->info().order, FieldOrder::top_first);
    EXPECT_EQ(frame->info().status, FrameStatus::good);
    EXPECT_EQ(frame->image().at(0, 0), "ace"[i]);
    EXPECT_EQ(frame->image().at(1, 0), "bdf"[i]);
  }
}

TEST(Recording, WithoutARateHasNoClock) {
  const test::TemporaryFolder folder;
  test::write_bytes(folder.file("a.y4m"), "YUV4MPEG2 W2 H1 F0:0 Cmono\nFRAME\nabFRAME\ncd");
  const auto source = open_y4m(folder.file("a.y4m"));
  EXPECT_EQ(source->info().frames, 2U);
  static_cast<void>(source->next());
  const auto second = source->next();
  EXPECT_EQ(second->info().clock, Clock::none);
  EXPECT_EQ(second->info().timestamp_ns, 0);
  EXPECT_EQ(second->info().sequence, 1U);
}

TEST(Recording, MixedInterlacingIsTakenFromEveryFrame) {
  const test::TemporaryFolder folder;
  test::write_bytes(folder.file("a.y4m"),
                    "YUV4MPEG2 W2 H1 Cmono Im\nFRAME Itii\nabFRAME Ibii\nabFRAME I1pp\nabFRAME\nab");
  const auto source = open_y4m(folder.file("a.y4m"));
  EXPECT_EQ(source->info().order, FieldOrder::unknown);
  for (const FieldOrder order :
       {FieldOrder::top_first, FieldOrder::bottom_first, FieldOrder::progressive, FieldOrder::unknown})
    EXPECT_EQ(source->next()->info().order, order);
}

TEST(Recording, ChromaIsPassedOver) {
  const test::TemporaryFolder folder;
  // 3x2 pixels of 4:2:0: two columns and one row of either chroma.
  test::write_bytes(folder.file("a.y4m"), "YUV4MPEG2 W3 H2 F25:1\nFRAME\nabcdefUUVVFRAME\nghijklUUVV");
  const auto source = open_y4m(folder.file("a.y4m"));
  EXPECT_EQ(source->info().frames, 2U);
  EXPECT_EQ(source->next()->image().at(2, 1), 'f');
  EXPECT_EQ(source->next()->image().at(0, 0), 'g');
  EXPECT_FALSE(source->next().has_value());
}

TEST(Recording, DeepSamplesAreLittleEndianInTheLowBits) {
  const test::TemporaryFolder folder;
  using namespace std::string_literals;
  test::write_bytes(folder.file("a.y4m"), "YUV4MPEG2 W2 H1 Cmono10\nFRAME\n\x01\x02\xff\x03"s);
  const auto frame = open_y4m(folder.file("a.y4m"))->next();
  EXPECT_EQ(frame->image().at(0, 0), 0x201);
  EXPECT_EQ(frame->image().at(1, 0), 1023);
  RecordingWriter writer(folder.file("b.y4m"), shape(2, 1, 10));
  writer.append(*frame);
  EXPECT_THAT(test::read_bytes(folder.file("b.y4m")), testing::EndsWith("\n\x01\x02\xff\x03"));
}

TEST(Recording, EveryFrameIsInTheFileAtOnce) {
  const test::TemporaryFolder folder;
  RecordingWriter writer(folder.file("a.y4m"), shape(5, 4, 8));
  for (std::uint64_t i = 0; i < 3; ++i) {
    writer.append(Picture(5, 4, 8, 1).view(), info_of(i));
    EXPECT_EQ(open_y4m(folder.file("a.y4m"))->info().frames, i + 1);
  }
  RecordingWriter moved(std::move(writer));
  moved.append(Picture(5, 4, 8, 1).view(), info_of(3));
  EXPECT_EQ(open_y4m(folder.file("a.y4m"))->info().frames, 4U);
}

TEST(Recording, FramesOutliveTheirSource) {
  const test::TemporaryFolder folder;
  {
    RecordingWriter writer(folder.file("a.y4m"), shape(50, 40, 8));
    for (std::uint32_t i = 0; i < 4; ++i) writer.append(Picture(50, 40, 8, i).view(), info_of(i));
  }
  std::vector<Frame> frames;
  {
    const auto source = open_y4m(folder.file("a.y4m"));
    while (auto frame = source->next()) frames.push_back(std::move(*frame));
    source->stop();
  }
  ASSERT_EQ(frames.size(), 4U);
  for (std::uint32_t i = 0; i < 4; ++i) EXPECT_TRUE(same_pixels(frames[i].image(), Picture(50, 40, 8, i).view()));
  std::thread([taken = std::move(frames)]() mutable { taken.clear(); }).join();
}

TEST(Recording, BuffersAreUsedAgain) {
  const test::TemporaryFolder folder;
  {
    RecordingWriter writer(folder.file("a.y4m"), shape(64, 48, 8));
    for (std::uint32_t i = 0; i < 50; ++i) writer.append(Picture(64, 48, 8, i).view(), info_of(i));
  }
  const auto source = open_y4m(folder.file("a.y4m"));
  std::vector<const std::byte*> seen;
  std::optional<Frame> held;  // one frame in hand while the next is read: two buffers
  std::uint32_t count = 0;
  while (auto frame = source->next()) {
    EXPECT_TRUE(same_pixels(frame->image(), Picture(64, 48, 8, count++).view()));
    if (std::find(seen.begin(), seen.end(), frame->image().data) == seen.end()) seen.push_back(frame->image().data);
    held = std::move(frame);
  }
  EXPECT_EQ(count, 50U);
  EXPECT_EQ(seen.size(), 2U);
}

TEST(Recording, StopEndsIt) {
  const test::TemporaryFolder folder;
  test::write_bytes(folder.file("a.y4m"), "YUV4MPEG2 W2 H1 Cmono\nFRAME\nabFRAME\ncd");
  const auto source = open_y4m(folder.file("a.y4m"));
  EXPECT_TRUE(source->next().has_value());
  source->stop();
  EXPECT_FALSE(source->next().has_value());
}

TEST(Recording, HoldingEveryBufferWaitsAndStopEndsTheWaiting) {
  const test::TemporaryFolder folder;
  const int width = 8192;  // 64 MiB a frame: eight buffers
  const int height = 8192;
  {
    test::write_bytes(folder.file("a.y4m"), "YUV4MPEG2 W8192 H8192 Cmono\n");
    const UniqueFd file(::open(folder.file("a.y4m").c_str(), O_WRONLY | O_APPEND | O_CLOEXEC));
    for (int i = 0; i < 9; ++i) {  // sparse
      const off_t end = ::lseek(file.get(), 0, SEEK_END);
      ASSERT_EQ(::write(file.get(), "FRAME\n", 6), 6);
      ASSERT_EQ(::ftruncate(file.get(), end + 6 + off_t{width} * height), 0);
    }
  }
  const std::uint32_t buffers = recording_buffers(std::size_t{width} * height);
  ASSERT_EQ(buffers, 8U);
  const auto source = open_y4m(folder.file("a.y4m"));
  std::vector<Frame> frames;
  for (std::uint32_t i = 0; i < buffers; ++i) frames.push_back(*source->next());
  auto ninth = std::async(std::launch::async, [&] { return source->next().has_value(); });
  EXPECT_EQ(ninth.wait_for(50ms), std::future_status::timeout);
  source->stop();
  ASSERT_EQ(ninth.wait_for(10s), std::future_status::ready);
  EXPECT_FALSE(ninth.get());
}

TEST(Recording, ReadsPipes) {
  const test::TemporaryFolder folder;
  {
    RecordingWriter writer(folder.file("a.y4m"), shape(300, 200, 12));
    for (std::uint32_t i = 0; i < 5; ++i) writer.append(Picture(300, 200, 12, i).view(), info_of(i * 2));
  }
  const std::string pipe = folder.file("pipe");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  std::thread writer([&] {
    const std::string bytes = test::read_bytes(folder.file("a.y4m"));
    const UniqueFd out(::open(pipe.c_str(), O_WRONLY | O_CLOEXEC));
    for (std::size_t at = 0; at < bytes.size();) {  // in pieces of odd sizes, so that lines and frames are torn
      const ssize_t count =
          ::write(out.get(), bytes.data() + at, std::min<std::size_t>(777 + at % 1313, bytes.size() - at));
      if (count <= 0) break;
      at += static_cast<std::size_t>(count);
    }
  });
  const auto source = open_y4m(pipe);
  EXPECT_FALSE(source->info().frames.has_value());
  for (std::uint32_t i = 0; i < 5; ++i) {
    const auto frame = source->next();
    ASSERT_TRUE(frame.has_value());
    expect_same(frame->info(), info_of(i * 2));
    EXPECT_TRUE(same_pixels(frame->image(), Picture(300, 200, 12, i).view()));
  }
  EXPECT_FALSE(source->next().has_value());
  writer.join();
}

TEST(Recording, StopEndsTheWaitingForAPipe) {
  const test::TemporaryFolder folder;
  const std::string pipe = folder.file("pipe");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const UniqueFd both(::open(pipe.c_str(), O_RDWR | O_CLOEXEC));  // never ends
  const std::string begin = "YUV4MPEG2 W2 H1 Cmono\nFRAME\nabFRAME\nc";
  ASSERT_EQ(::write(both.get(), begin.data(), begin.size()), static_cast<ssize_t>(begin.size()));
  const auto source = open_y4m(pipe);
  EXPECT_EQ(source->next()->image().at(1, 0), 'b');
  auto second = std::async(std::launch::async, [&] { return source->next().has_value(); });
  EXPECT_EQ(second.wait_for(50ms), std::future_status::timeout);
  source->stop();
  ASSERT_EQ(second.wait_for(10s), std::future_status::ready);
  EXPECT_FALSE(second.get());
}

TEST(Recording, GoesOnBeyondTwoGigabytes) {
  const test::TemporaryFolder folder;
  constexpr off_t pixels = off_t{4096} * 4096;
  constexpr int frames = 140;  // 2.3 GB, sparse
  {
    test::write_bytes(folder.file("a.y4m"), "YUV4MPEG2 W4096 H4096 F25:1 Cmono\n");
    const UniqueFd file(::open(folder.file("a.y4m").c_str(), O_WRONLY | O_CLOEXEC));
    off_t at = ::lseek(file.get(), 0, SEEK_END);
    for (int i = 0; i < frames; ++i) {
      const auto number = static_cast<char>(i);
      ASSERT_EQ(::pwrite(file.get(), "FRAME\n", 6, at), 6);
      ASSERT_EQ(::pwrite(file.get(), &number, 1, at + 6 + pixels - 1), 1);
      at += 6 + pixels;
    }
    ASSERT_GT(at, off_t{1} << 31U);
  }
  const auto source = open_y4m(folder.file("a.y4m"));
  EXPECT_EQ(source->info().frames, static_cast<std::uint64_t>(frames));
  int count = 0;
  while (const auto frame = source->next()) EXPECT_EQ(frame->image().at(4095, 4095), count++);
  EXPECT_EQ(count, frames);
}

}  // namespace
}  // namespace vsfind
