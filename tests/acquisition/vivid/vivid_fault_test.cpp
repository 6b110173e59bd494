/// What becomes of faults: all are told of once, none is mistaken for a good frame, and recording goes on.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>

#include "tests/acquisition/vivid/results.h"
#include "tests/app/shell.h"

namespace vsfind::test {
namespace {

using testing::HasSubstr;
using testing::Not;

/// What a recording of the guest says about itself, and what the log says.
struct Story {
  explicit Story(const std::string& step)
      : code(guest_code(step)), log(guest_text(step + ".err")), recording(guest_recording(step)) {
    std::uint64_t next = 0;
    for (const Frame& frame : recording.frames) {
      if (frame.info().status != FrameStatus::good) ++bad;
      EXPECT_GE(frame.info().sequence, next) << "frames are numbered upwards";
      missing += frame.info().sequence - next;
      if (frame.info().sequence > next) ++gaps;
      next = frame.info().sequence + 1;
    }
    std::smatch found;
    if (std::regex_search(log, found, std::regex("([0-9]+) frames in .* ([0-9]+) bad, ([0-9]+) missing"))) {
      EXPECT_EQ(std::stoull(found[1]), recording.frames.size());
      EXPECT_EQ(std::stoull(found[2]), bad);
      EXPECT_EQ(std::stoull(found[3]), missing);
    } else {
      ADD_FAILURE() << "no summary: " << log;
    }
  }
  [[nodiscard]] int count(const std::string& text) const {
    int result = 0;
    for (auto at = log.find(text); at != std::string::npos; at = log.find(text, at + 1)) ++result;
    return result;
  }
  [[nodiscard]] int warnings() const { return count("warning"); }

  int code;
  std::string log;
  GuestRecording recording;
  std::uint64_t bad = 0;
  std::uint64_t missing = 0;
  int gaps = 0;
};

TEST_F(VividTest, DroppedBuffersAreGapsAndToldOfOnce) {
  const Story story("fault_dropped");
  EXPECT_EQ(story.code, 0);
  EXPECT_EQ(story.bad, 0U);
  EXPECT_GE(story.missing, 4U) << "of some 40, 40 per cent";
  EXPECT_GE(story.gaps, 2);
  EXPECT_EQ(story.count("is losing frames"), 1) << story.log;
  EXPECT_THAT(story.log, HasSubstr(fmt::format("{} lost by the driver", story.missing)));
}

TEST_F(VividTest, AFlaggedBufferIsABadFrame) {
  const Story story("fault_flagged");
  EXPECT_EQ(story.code, 0);
  EXPECT_EQ(story.bad, 1U);
  EXPECT_GE(story.recording.frames.size(), 16U);
  EXPECT_EQ(story.count("bad frames: flagged by the driver"), 1) << story.log;
}

/// Steps in which the camera is lost and comes back.
struct Loss {
  const char* step;
  const char* reason;
};
void PrintTo(const Loss& loss, std::ostream* stream) { *stream << loss.step; }
class VividLoss : public VividTestWith<Loss> {};

INSTANTIATE_TEST_SUITE_P(, VividLoss,
                         testing::Values(Loss{"fault_stream_error", "the stream broke off"},
                                         Loss{"fault_no_signal", "no signal at input 'S-Video 0'"},
                                         Loss{"fault_other_standard", "the signal has changed"},
                                         Loss{"fault_silent", "no frame for 1.5 s"},
                                         Loss{"fault_disconnect", "it was unplugged"},
                                         Loss{"fault_unbind", "it was unplugged"}),
                         [](const auto& tested) { return std::string(tested.param.step); });

TEST_P(VividLoss, IsToldOfOnceAndRecoveredFrom) {
  const Loss& loss = GetParam();
  const Story story(loss.step);
  EXPECT_EQ(story.code, 0) << story.log;
  EXPECT_THAT(story.log, HasSubstr(loss.reason));
  EXPECT_EQ(story.count("trying again until it is back"), 1) << story.log;
  EXPECT_EQ(story.count("frames come again"), 1) << story.log;
  EXPECT_EQ(story.bad, 0U);
  EXPECT_GE(story.gaps, 1) << "the loss shows in the frame numbers";
  EXPECT_GE(story.recording.frames.size(), 16U);
  // None of noise, none half written: the picture stands still.
  const ImageView& first = story.recording.frames.at(0).image();
  for (const Frame& frame : story.recording.frames) {
    for (int y = 7; y < first.height; y += 9) {
      for (int x = 0; x < first.width; x += 7)
        ASSERT_EQ(frame.image().at(x, y), first.at(x, y))
            << "frame " << frame.info().sequence << " at " << x << "," << y;
    }
  }
}

/// A run that follows the signal from PAL to NTSC: its recording goes on in another file.
void expect_both_sizes(const std::string& step) {
  EXPECT_EQ(guest_code(step), 0) << guest_text(step + ".err");
  const GuestRecording pal = guest_recording(step);
  const GuestRecording ntsc = guest_recording(step + "-2");
  EXPECT_EQ(pal.info.height, 576);
  EXPECT_EQ(pal.info.order, FieldOrder::top_first);
  EXPECT_EQ(pal.info.pixel_aspect, (Ratio{59, 54}));
  EXPECT_EQ(ntsc.info.height, 480);
  EXPECT_EQ(ntsc.info.order, FieldOrder::bottom_first);
  EXPECT_EQ(ntsc.info.pixel_aspect, (Ratio{10, 11}));
  EXPECT_NEAR(ntsc.info.frame_rate.value(), 30e3 / 1001, 0.5);
  std::uint64_t next = 0;
  for (const GuestRecording* recording : {&pal, &ntsc}) {
    EXPECT_GE(recording->frames.size(), 8U);
    // The first frame of either standard tells how it has to look.
    const ImageView& first = recording->frames.at(0).image();
    for (const Frame& frame : recording->frames) {
      EXPECT_EQ(frame.info().status, FrameStatus::good);
      EXPECT_GE(frame.info().sequence, next) << "numbers go on";
      next = frame.info().sequence + 1;
      for (int y = 7; y < first.height; y += 9) {
        for (int x = 0; x < first.width; x += 7) ASSERT_EQ(frame.image().at(x, y), first.at(x, y)) << x << "," << y;
      }
    }
  }
  EXPECT_GT(ntsc.frames.at(0).info().sequence, pal.frames.back().info().sequence + 1) << "the change is a gap";
}

TEST_F(VividTest, ARecordingGoesOnInAnotherFileWhereTheSignalHasAnotherSize) {
  expect_both_sizes("record_other_size");
  EXPECT_THAT(guest_text("record_other_size.err"),
              HasSubstr("now gives 720x480 pixels of 8 bits, before 720x576 of 8"));
}

TEST_F(VividTest, LiveSearchesAndRecordsOnWhereTheSignalHasAnotherSize) {
  expect_both_sizes("live_other_size");
  EXPECT_THAT(guest_text("live_other_size.err"), HasSubstr("the frames have changed; recording goes on in"));
  std::vector<std::map<std::string, std::string>> again;
  for (const std::string file : {"live_other_size", "live_other_size-2"}) {
    const Outcome found =
        vsfind({"replay", guest_file(file + ".y4m"), "--model", VIVID_MODEL, "--field", "split", "--csv", "-"});
    EXPECT_EQ(found.code, 0) << found.err;
    for (auto& row : csv_rows(found.out)) again.push_back(std::move(row));
  }
  auto rows = csv_rows(guest_text("live_other_size.csv"));
  for (auto* all : {&rows, &again}) {
    for (auto& row : *all) {
      for (const char* other : {"source", "search_ms", "latency_ms"}) row.erase(other);
    }
  }
  EXPECT_EQ(rows, again) << "each size with its own field order and pixel aspect";
  EXPECT_EQ(rows.front()["field"], "top");
  EXPECT_EQ(rows.back()["field"], "top") << "of NTSC the later one";
}

TEST_F(VividTest, ACameraThatIsHeldIsToldOf) {
  EXPECT_EQ(guest_code("second_program"), 4);
  EXPECT_THAT(guest_text("second_program.err"), HasSubstr("v4l2:/dev/video0"));
  EXPECT_THAT(guest_text("second_program.err"), HasSubstr("it is held by another program"));
  const Story first("fault_held");
  EXPECT_EQ(first.code, 0);
  EXPECT_EQ(first.bad, 0U) << "whoever holds it is not disturbed";
  EXPECT_EQ(first.count("trying again"), 0) << first.log;
  EXPECT_THAT(guest_text("cameras_held.out"), HasSubstr("(held by another program)"));
}

TEST_F(VividTest, ACameraThatDoesNotStartIsAnErrorAtOnce) {
  EXPECT_EQ(guest_code("fault_never_starts"), 4);
  EXPECT_THAT(guest_text("fault_never_starts.err"), HasSubstr("v4l2:/dev/video0: does not start"));
}

TEST_F(VividTest, AFullDiskKeepsWholeFrames) {
  EXPECT_EQ(guest_code("fault_disk_full"), 3);
  const Story story("fault_disk_full");
  EXPECT_THAT(story.log, HasSubstr("/small/full.y4m: frame 7 cannot be written: No space left on device"));
  EXPECT_EQ(story.recording.frames.size(), 7U) << "of 415 kB each, on 3 MiB";
}

TEST_F(VividTest, TheDriversCounterMayPassItsEnd) {
  const Story story("fault_wrap");
  EXPECT_EQ(story.code, 0);
  EXPECT_EQ(story.recording.frames.size(), 150U);
  EXPECT_LT(story.recording.frames.back().info().sequence, 5000U);
}

}  // namespace
}  // namespace vsfind::test
