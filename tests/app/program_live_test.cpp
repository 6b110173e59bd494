// `vsfind live` on recordings: everything but cameras.

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "tests/app/scene.h"

namespace vsfind::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class Live : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(part_.training().code, 0) << part_.training().err;
    std::vector<cv::Mat> frames;
    for (int i = 0; i < 8; ++i) frames.push_back(i == 5 ? scene_without_part() : scene(60 + 7 * i, 50 + 5 * i));
    write_y4m(part_ / "line.y4m", frames, 't', " A59:54");
    write_y4m(part_ / "other.y4m", {frames[0], frames[1]}, 'p');
  }
  [[nodiscard]] Outcome live(std::vector<std::string> more) const {
    more.insert(more.begin(), {"live", "--model", part_.model()});
    return vsfind(more);
  }
  /// Rows without source and times.
  static std::vector<std::map<std::string, std::string>> bare(const std::string& csv) {
    auto rows = csv_rows(csv);
    for (auto& row : rows) {
      for (const char* column : {"source", "search_ms", "latency_ms"}) row.erase(column);
    }
    return rows;
  }

  TrainedPart part_;
};

TEST_F(Live, ARecordingIsSearchedAsByReplayAndItsRecordingIsTheSame) {
  const std::string uri = "file:" + (part_ / "line.y4m");
  const Outcome outcome =
      live({"--source", uri, "--field", "split", "--min-score", "0.3", "--record", part_ / "again.y4m"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const auto rows = bare(outcome.out);
  ASSERT_EQ(rows.size(), 16U);
  EXPECT_EQ(csv_rows(outcome.out)[0].at("source"), part_ / "line.y4m");
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("8 frames: "), HasSubstr("latency median")));
  for (const std::string name : {"line.y4m", "again.y4m"}) {
    const Outcome replay =
        vsfind({"replay", part_ / name, "--model", part_.model(), "--field", "split", "--min-score", "0.3"});
    EXPECT_EQ(bare(replay.out), rows) << name;
  }
}

TEST_F(Live, SeveralSourcesAreToldApartAndHaveTheirOwn) {
  write_file(
      part_ / "c.yaml",
      "model: part.vsm\nfield: split\ncsv: rows.csv\nsources:\n  - source: file:line.y4m\n    pixel_aspect: 1:1\n"
      "    record: line-again.y4m\n  - source: file:other.y4m\n    field: frame\n");
  const Outcome outcome = vsfind({"live", "--config", part_ / "c.yaml"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  std::map<std::string, int> count;
  for (const auto& row : csv_rows(read_file(part_ / "rows.csv"))) {
    ++count[std::filesystem::path(row.at("source")).filename().string() + " " + row.at("field")];
  }
  EXPECT_EQ(count, (std::map<std::string, int>{{"line.y4m top", 8}, {"line.y4m bottom", 8}, {"other.y4m frame", 2}}));
  EXPECT_TRUE(std::filesystem::exists(part_ / "line-again.y4m"));
  // The command line goes before every part of the configuration.
  const Outcome frames = vsfind({"live", "--config", part_ / "c.yaml", "--field", "frame", "--csv", "-"});
  EXPECT_EQ(csv_rows(frames.out).size(), 10U);
}

TEST_F(Live, EndsAfterFramesOrSeconds) {
  EXPECT_EQ(
      csv_rows(live({"--source", "file:" + (part_ / "line.y4m"), "--pixel-aspect", "1:1", "--frames", "3"}).out).size(),
      3U);
  ASSERT_EQ(::mkfifo((part_ / "pipe").c_str(), 0600), 0);
  // A pipe that stays open and gives nothing more.
  Process process({"live", "--source", "file:" + (part_ / "pipe"), "--model", part_.model(), "--pixel-aspect", "1:1",
                   "--seconds", "0.5"});
  std::ofstream pipe(part_ / "pipe", std::ios::binary);
  pipe << read_file(part_ / "line.y4m") << std::flush;
  const Outcome outcome = process.wait();
  EXPECT_EQ(outcome.code, 0) << outcome.err;
}

TEST_F(Live, WhatCannotBeWrittenCostsItselfOnly) {
  const std::string uri = "file:" + (part_ / "line.y4m");
  const Outcome outcome = live({"--source", uri, "--pixel-aspect", "1:1", "--csv", part_ / "rows.csv", "--jsonl",
                                "/dev/full", "--record", "/dev/full"});
  EXPECT_EQ(outcome.code, 3);
  EXPECT_EQ(csv_rows(read_file(part_ / "rows.csv")).size(), 8U);
  std::size_t told = 0;
  for (const auto& line : lines_of(outcome.err)) told += line.find("No space left") != std::string::npos ? 1 : 0;
  EXPECT_EQ(told, 2U) << outcome.err;  // once for each file
  EXPECT_THAT(outcome.err, HasSubstr("16 rows, pictures or recorded frames could not be written"));
}

TEST_F(Live, MistakesAreNamed) {
  const auto complaint = [&](const std::vector<std::string>& more) {
    const Outcome outcome = live(more);
    EXPECT_EQ(outcome.code, 2) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(lines_of(outcome.err).size(), 1U) << outcome.err;
    return outcome.err;
  };
  const std::string uri = "file:" + (part_ / "line.y4m");
  EXPECT_THAT(complaint({}), HasSubstr("--source URI is needed"));
  EXPECT_THAT(complaint({"--source", "usb:1"}), AllOf(HasSubstr("'usb:'"), HasSubstr("gige:NAME-OR-ADDRESS")));
  EXPECT_THAT(complaint({"--source", uri, "--source", uri}), HasSubstr("is given twice"));
  EXPECT_THAT(complaint({"--source", uri, "--region", "900,0,5,5"}), HasSubstr("--region 900,0,5,5 lies outside"));
  EXPECT_EQ(live({"--source", "file:/nowhere.y4m"}).code, 3);
}

}  // namespace
}  // namespace vsfind::test
