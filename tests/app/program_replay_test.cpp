#include <gmock/gmock.h>
#include <sys/stat.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <thread>

#include "tests/app/scene.h"

namespace vsfind::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class Replay : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(part_.training().code, 0) << part_.training().err;
    for (int i = 0; i < 8; ++i) frames_.push_back(i == 5 ? scene_without_part() : scene(60 + 7 * i, 50 + 5 * i));
    write_y4m(part_ / "line.y4m", frames_, 't', " A59:54");
  }
  [[nodiscard]] Outcome replay(std::vector<std::string> more) const {
    std::vector<std::string> arguments{"replay", part_ / "line.y4m", "--model", part_.model(), "--pixel-aspect", "1:1"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return vsfind(arguments);
  }

  TrainedPart part_;
  std::vector<cv::Mat> frames_;
};

/// Rows without the columns that time decides.
std::vector<std::map<std::string, std::string>> without_times(const std::string& csv) {
  auto rows = csv_rows(csv);
  for (auto& row : rows) {
    row.erase("search_ms");
    row.erase("latency_ms");
  }
  return rows;
}

TEST_F(Replay, GivesARowPerFrame) {
  const Outcome outcome = replay({});
  EXPECT_EQ(outcome.code, 0);
  const auto rows = csv_rows(outcome.out);
  ASSERT_EQ(rows.size(), 8U);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(rows[i].at("source"), part_ / "line.y4m");
    EXPECT_EQ(rows[i].at("frame"), std::to_string(i));
    EXPECT_EQ(rows[i].at("timestamp_ns"), std::to_string(i * 40'000'000));
    EXPECT_EQ(rows[i].at("field"), "frame");
    EXPECT_EQ(rows[i].at("status"), i == 5 ? "not_found" : "found");
    if (i == 5) continue;
    EXPECT_NEAR(std::stod(rows[i].at("x")), 99.5 + 7.0 * static_cast<double>(i), 0.03);
    EXPECT_NEAR(std::stod(rows[i].at("y")), 89.5 + 5.0 * static_cast<double>(i), 0.03);
  }
  EXPECT_THAT(outcome.err, HasSubstr("8 frames: 7 found, 1 not found, 0 bad"));
  EXPECT_EQ(outcome.err.find('\r'), std::string::npos);  // no progress bar unless stderr is a terminal
}

TEST_F(Replay, SplitGivesTheEarlierFieldFirst) {
  write_y4m(part_ / "ntsc.y4m", frames_, 'b');
  const auto top_first = csv_rows(replay({"--field", "split"}).out);
  ASSERT_EQ(top_first.size(), 16U);
  EXPECT_EQ(top_first[0].at("field"), "top");
  EXPECT_EQ(top_first[1].at("field"), "bottom");
  EXPECT_EQ(top_first[1].at("frame"), "0");
  const auto bottom_first =
      csv_rows(vsfind({"replay", part_ / "ntsc.y4m", "--model", part_.model(), "--field", "split"}).out);
  ASSERT_EQ(bottom_first.size(), 16U);
  EXPECT_EQ(bottom_first[0].at("field"), "bottom");
  EXPECT_EQ(bottom_first[1].at("field"), "top");
  const auto only = csv_rows(replay({"--field", "bottom"}).out);
  ASSERT_EQ(only.size(), 8U);
  EXPECT_EQ(only[3].at("field"), "bottom");
  EXPECT_EQ(only[3].at("y"), top_first[7].at("y"));
}

TEST_F(Replay, RowsAreTheSameAgainAndWithMoreThreads) {
  const auto first = without_times(replay({"--field", "split"}).out);
  ASSERT_EQ(first.size(), 16U);
  EXPECT_EQ(without_times(replay({"--field", "split"}).out), first);
  EXPECT_EQ(without_times(replay({"--field", "split", "--threads", "2"}).out), first);
}

TEST_F(Replay, TakesThePixelAspectFromTheHeader) {
  const Outcome outcome = vsfind({"replay", part_ / "line.y4m", "--model", part_.model(), "--min-score", "0", "-v"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.err, HasSubstr("pixel aspect 59:54 as the source says"));
  // The pattern was trained with square pixels.
  EXPECT_THAT(outcome.err, HasSubstr("was trained with pixel aspect 1, the pictures are taken to have 1.0926"));
  const auto rows = csv_rows(outcome.out);
  ASSERT_EQ(rows.size(), 8U);
  for (const auto& row : rows) {
    if (row.at("status") != "found") continue;
    EXPECT_NEAR(std::stod(row.at("x")) / std::stod(row.at("image_x")), 59.0 / 54.0, 1e-4);
  }
}

TEST_F(Replay, AFolderIsASequenceToo) {
  std::filesystem::create_directory(part_ / "frames");
  for (std::size_t i = 0; i < 3; ++i) cv::imwrite(part_ / ("frames/" + std::to_string(i) + ".png"), frames_[i]);
  write_file(part_ / "frames/1a.png", "broken");
  const Outcome outcome =
      vsfind({"replay", part_ / "frames", "--model", part_.model(), "--field", "split", "--overlay", part_ / "o"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const auto rows = csv_rows(outcome.out);
  ASSERT_EQ(rows.size(), 7U);  // the damaged image gives one row, not one per field
  EXPECT_EQ(rows[4].at("frame"), "2");
  EXPECT_EQ(rows[4].at("status"), "bad_frame");
  EXPECT_EQ(rows[4].at("search_ms"), "");
  EXPECT_NE(rows[4].at("latency_ms"), "");
  EXPECT_EQ(rows[6].at("frame"), "3");
  EXPECT_THAT(outcome.err, HasSubstr("4 frames: 6 found, 0 not found, 1 bad"));
  EXPECT_TRUE(std::filesystem::exists(part_ / "o/s0-00000003-b-bottom.png"));
  EXPECT_FALSE(std::filesystem::exists(part_ / "o/s0-00000002-a-top.png"));
}

TEST_F(Replay, ACutRecordingGivesItsWholeFramesFirst) {
  const auto size = std::filesystem::file_size(part_ / "line.y4m");
  std::filesystem::resize_file(part_ / "line.y4m", size - 1000);
  const Outcome outcome = replay({});
  EXPECT_EQ(outcome.code, 3);
  EXPECT_EQ(csv_rows(outcome.out).size(), 7U);
  const auto lines = lines_of(outcome.err);
  ASSERT_EQ(lines.size(), 2U) << outcome.err;
  EXPECT_THAT(lines[0], AllOf(HasSubstr("vsfind: "), HasSubstr("line.y4m")));
  EXPECT_THAT(lines[1], HasSubstr("7 frames: 6 found"));
}

TEST_F(Replay, ARecordingOfImpossiblePixelsNeedsTheOption) {
  write_y4m(part_ / "odd.y4m", frames_, 'p', " A1000:1");
  const Outcome outcome = vsfind({"replay", part_ / "odd.y4m", "--model", part_.model()});
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("odd.y4m"), HasSubstr("1000:1")));
  EXPECT_EQ(vsfind({"replay", part_ / "odd.y4m", "--model", part_.model(), "--pixel-aspect", "1:1"}).code, 0);
}

TEST_F(Replay, TheConfigurationServesAndTheCommandLineOverridesIt) {
  std::filesystem::create_directory(part_ / "conf");
  write_file(part_ / "conf/c.yaml",
             "source: ../line.y4m\nmodel: [../part.vsm]\nfield: split\npixel_aspect: 1:1\ncsv: rows.csv\n");
  const Outcome outcome = vsfind({"replay", "--config", part_ / "conf/c.yaml"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(csv_rows(read_file(part_ / "conf/rows.csv")).size(), 16U);
  const Outcome overridden = vsfind(
      {"replay", "--config", part_ / "conf/c.yaml", "--field", "frame", "--csv", "-", "--jsonl", part_ / "rows.jsonl"});
  EXPECT_EQ(csv_rows(overridden.out).size(), 8U);
  const auto lines = lines_of(read_file(part_ / "rows.jsonl"));
  ASSERT_EQ(lines.size(), 8U);
  for (const auto& line : lines) EXPECT_EQ(nlohmann::json::parse(line)["field"], "frame");
}

TEST_F(Replay, OverlaysShowEverySearchedPicture) {
  EXPECT_EQ(replay({"--overlay", part_ / "o"}).code, 0);
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(part_ / "o")) {
    EXPECT_EQ(cv::imread(entry.path().string()).size(), cv::Size(scene_width, scene_height));
    ++count;
  }
  EXPECT_EQ(count, 8);
}

TEST_F(Replay, ATerminalSeesProgressWithRateAndTimeLeft) {
  const std::string program = std::string(VSFIND_PROGRAM) + " replay " + (part_ / "line.y4m") + " --model " +
                              part_.model() + " --pixel-aspect 1:1 --csv " + (part_ / "rows.csv");
  // script(1) gives the program a terminal.
  const auto on_terminal = [&](const std::string& more) {
    const std::string command = "script -qec '" + program + more + "' /dev/null </dev/null >" + (part_ / "screen");
    EXPECT_EQ(std::system(command.c_str()), 0);
    return read_file(part_ / "screen");
  };
  EXPECT_THAT(on_terminal(""), AllOf(HasSubstr("\r["), HasSubstr("/8 frames, "), HasSubstr("/s, "), HasSubstr(" left"),
                                     HasSubstr("8 frames: 7 found")));
  EXPECT_EQ(on_terminal(" --quiet"), "");
}

/// A recording that comes through a pipe and never ends by itself: the program waits in the middle.
class ReplayOfPipe : public Replay {
 protected:
  void SetUp() override {
    Replay::SetUp();
    ASSERT_EQ(::mkfifo((part_ / "pipe.y4m").c_str(), 0600), 0);
    const std::string bytes = read_file(part_ / "line.y4m");
    process_ = std::make_unique<Process>(std::vector<std::string>{
        "replay", part_ / "pipe.y4m", "--model", part_.model(), "--pixel-aspect", "1:1", "--csv", part_ / "rows.csv"});
    pipe_.open(part_ / "pipe.y4m", std::ios::binary);
    pipe_ << bytes << std::flush;
    ASSERT_TRUE(pipe_);
  }
  void wait_for_rows(std::size_t count) const {
    for (int i = 0; i < 500 && lines_of(read_file(part_ / "rows.csv")).size() < count + 1; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }

  std::unique_ptr<Process> process_;
  std::ofstream pipe_;
};

TEST_F(ReplayOfPipe, RowsAreThereAtOnceAndWholeAfterAKill) {
  wait_for_rows(8);
  process_->kill(SIGKILL);
  EXPECT_EQ(process_->wait().code, 128 + SIGKILL);
  const std::string text = read_file(part_ / "rows.csv");
  EXPECT_EQ(csv_rows(text).size(), 8U);
  EXPECT_EQ(text.back(), '\n');
}

TEST_F(ReplayOfPipe, ASignalEndsTheWaitingProgramWithTheSummary) {
  wait_for_rows(8);
  process_->kill(SIGINT);
  const Outcome outcome = process_->wait();  // the pipe stays open: nothing else ends it
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.err, HasSubstr("8 frames: 7 found"));
  EXPECT_EQ(csv_rows(read_file(part_ / "rows.csv")).size(), 8U);
}

TEST_F(Replay, ASignalAmongManyFramesEndsItWithWholeRows) {
  for (const int signal : {SIGINT, SIGTERM}) {
    std::vector<cv::Mat> many;
    for (int i = 0; i < 2000; ++i) many.push_back(frames_[static_cast<std::size_t>(i) % frames_.size()]);
    write_y4m(part_ / "long.y4m", many, 'p');
    const std::string rows = part_ / "long.csv";
    std::filesystem::remove(rows);
    Process process({"replay", part_ / "long.y4m", "--model", part_.model(), "--csv", rows});
    while (lines_of(read_file(rows)).size() < 5) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    process.kill(signal);
    const Outcome outcome = process.wait();
    EXPECT_EQ(outcome.code, 0);
    const auto found = csv_rows(read_file(rows));
    EXPECT_LT(found.size(), 2000U);
    EXPECT_THAT(outcome.err, HasSubstr("vsfind: " + std::to_string(found.size()) + " frames: "));
  }
}

}  // namespace
}  // namespace vsfind::test
