// `vsfind live` on GigE cameras: a server process shows frames of ours in a network of its own.

#include <gmock/gmock.h>

#include <chrono>
#include <csignal>
#include <set>
#include <thread>

#include "tests/acquisition/gige_network.h"
#include "tests/app/scene.h"

namespace vsfind::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

using Row = std::map<std::string, std::string>;

/// A row without what the way of the frame decides.
Row bare(Row row) {
  for (const char* column : {"source", "frame", "timestamp_ns", "search_ms", "latency_ms"}) row.erase(column);
  return row;
}

class LiveGige : public testing::Test {
 protected:
  void SetUp() override {
    if (const std::string why = enter_own_network(); !why.empty()) GTEST_SKIP() << why;
    ASSERT_EQ(part_.training().code, 0) << part_.training().err;
    std::vector<cv::Mat> frames;
    for (int i = 0; i < 8; ++i) frames.push_back(i == 5 ? scene_without_part() : scene(60 + 7 * i, 50 + 5 * i));
    write_y4m(part_ / "line.y4m", frames, 'p');
    replayed_ = csv_rows(vsfind({"replay", part_ / "line.y4m", "--model", part_.model()}).out);
    ASSERT_EQ(replayed_.size(), 8U);
  }
  [[nodiscard]] std::vector<std::string> server(const std::string& address, const std::string& rate) const {
    return {address, "S" + address.substr(address.rfind('.') + 1), "320x240", rate, "--frames", part_ / "line.y4m"};
  }
  [[nodiscard]] std::vector<std::string> live(std::vector<std::string> more) const {
    more.insert(more.begin(), {"live", "--model", part_.model()});
    return more;
  }
  /// Rows of a source are those of the recording, in its order, whichever came first.
  void expect_replayed(const std::vector<Row>& rows) const { expect_replayed(rows, replayed_); }
  static void expect_replayed(const std::vector<Row>& rows, const std::vector<Row>& replayed) {
    ASSERT_FALSE(rows.empty());
    std::map<std::pair<std::size_t, std::string>, Row> wanted;
    std::size_t frames = 0;
    for (const Row& row : replayed) {
      const std::size_t frame = std::stoull(row.at("frame"));
      wanted[{frame, row.at("field")}] = bare(row);
      frames = std::max(frames, frame + 1);
    }
    std::set<std::size_t> starts;
    for (std::size_t start = 0; start < frames; ++start) {
      bool all = true;
      const std::uint64_t first = std::stoull(rows[0].at("frame"));
      for (const Row& row : rows) {
        if (row.at("status") == "bad_frame") continue;
        const std::size_t place = (start + std::stoull(row.at("frame")) - first) % frames;
        all = all && bare(row) == wanted[{place, row.at("field")}];
      }
      if (all) starts.insert(start);
    }
    std::string shown;
    for (const Row& row : rows) shown += row.at("frame") + ' ' + row.at("status") + ' ' + row.at("x") + '\n';
    EXPECT_EQ(starts.size(), 1U) << shown;
  }
  void wait_for_rows(const std::string& file, std::size_t count) const {
    for (int i = 0; i < 1000 && lines_of(read_file(file)).size() <= count; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    ASSERT_GT(lines_of(read_file(file)).size(), count);
  }

  TrainedPart part_;
  std::vector<Row> replayed_;
};

TEST_F(LiveGige, RowsAreThoseOfTheFramesServedAndOfTheRecordingMade) {
  const GigeServer camera(server("127.0.0.1", "40"));
  const Outcome outcome = vsfind(live(
      {"--source", "gige:127.0.0.1", "--frames", "30", "--record", part_ / "rec.y4m", "--report", part_ / "report"}));
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const auto rows = csv_rows(outcome.out);
  ASSERT_EQ(rows.size(), 30U);
  expect_replayed(rows);
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("30 frames: "), HasSubstr("latency median"), HasSubstr("gige:127.0.0.1: "),
                                 HasSubstr("frames complete")));
  const std::string page = read_file(part_ / "report/report.html");
  for (const char* words : {"gige:127.0.0.1", "<b>30</b>", "Latency", "Weakest matches", "Failures", "</html>"})
    EXPECT_NE(page.find(words), std::string::npos) << words;
  const auto again = csv_rows(vsfind({"replay", part_ / "rec.y4m", "--model", part_.model()}).out);
  ASSERT_EQ(again.size(), rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(again[i].at("frame"), rows[i].at("frame"));
    EXPECT_EQ(again[i].at("timestamp_ns"), rows[i].at("timestamp_ns"));
    EXPECT_EQ(bare(again[i]), bare(rows[i]));
  }
}

TEST_F(LiveGige, BothFieldsOfAnInterlacedCameraAreFound) {
  const auto replayed =
      csv_rows(vsfind({"replay", part_ / "line.y4m", "--model", part_.model(), "--field", "split"}).out);
  ASSERT_EQ(replayed.size(), 16U);
  auto words = server("127.0.0.1", "40");
  words.emplace_back("--interlaced");
  const GigeServer camera(words);
  for (const std::string mode : {"ConcatenatedNewFields", "DeinterlacedNewFields"}) {
    SCOPED_TRACE(mode);
    const Outcome outcome = vsfind(live(
        {"--source", "gige:127.0.0.1", "--frames", "10", "--field", "split", "--control", "FieldOutputMode=" + mode}));
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    const auto rows = csv_rows(outcome.out);
    EXPECT_GE(rows.size(), 15U);
    expect_replayed(rows, replayed);
    EXPECT_EQ(rows[0].at("field"), "top");
  }
}

TEST_F(LiveGige, FieldsThatComeInTurnAreSearchedAsThemselves) {
  const auto replayed =
      csv_rows(vsfind({"replay", part_ / "line.y4m", "--model", part_.model(), "--field", "split"}).out);
  auto words = server("127.0.0.1", "40");
  words.emplace_back("--interlaced");
  const GigeServer camera(words);
  const Outcome outcome =
      vsfind(live({"--source", "gige:127.0.0.1", "--frames", "16", "--field", "split", "--size", "320x240", "--control",
                   "FieldOutputMode=Field0First", "--record", part_ / "fields.y4m"}));
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const auto rows = csv_rows(outcome.out);
  ASSERT_EQ(rows.size(), 16U);
  expect_replayed(rows, replayed);
  std::map<std::string, int> fields;
  for (const Row& row : rows) ++fields[row.at("field")];
  EXPECT_EQ(fields.size(), 2U);
  EXPECT_GE(fields["top"], 5);
  EXPECT_GE(fields["bottom"], 5);
  const auto again =
      csv_rows(vsfind({"replay", part_ / "fields.y4m", "--model", part_.model(), "--field", "split"}).out);
  ASSERT_EQ(again.size(), rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) EXPECT_EQ(bare(again[i]), bare(rows[i]));
}

TEST_F(LiveGige, TwoCamerasAtOnce) {
  const GigeServer one(server("10.9.0.1", "25"));
  const GigeServer two(server("10.9.0.2", "25"));
  const Outcome outcome = vsfind(live({"--source", "gige:10.9.0.1", "--source", "gige:10.9.0.2", "--frames", "20"}));
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, Not(HasSubstr("CRITICAL")));
  std::map<std::string, std::vector<Row>> of_source;
  for (const auto& row : csv_rows(outcome.out)) of_source[row.at("source")].push_back(row);
  ASSERT_EQ(of_source.size(), 2U);
  for (const auto& [source, rows] : of_source) {
    SCOPED_TRACE(source);
    EXPECT_EQ(rows.size(), 20U);
    expect_replayed(rows);
  }
}

TEST_F(LiveGige, GoesOnByItselfWhenTheCameraIsBackAndEndsWithASignal) {
  auto camera = std::make_unique<GigeServer>(server("127.0.0.1", "40"));
  Process process(live({"--source", "gige:127.0.0.1", "--csv", part_ / "rows.csv", "--frame-timeout", "0.5"}));
  wait_for_rows(part_ / "rows.csv", 10);
  camera->kill();
  std::this_thread::sleep_for(std::chrono::milliseconds(1200));
  const std::size_t before = lines_of(read_file(part_ / "rows.csv")).size();
  camera = std::make_unique<GigeServer>(server("127.0.0.1", "40"));
  wait_for_rows(part_ / "rows.csv", before + 10);
  process.kill(SIGTERM);
  const Outcome outcome = process.wait();
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  std::size_t faults = 0;
  for (const auto& line : lines_of(outcome.err)) faults += line.find("trying again") != std::string::npos ? 1 : 0;
  EXPECT_EQ(faults, 1U) << outcome.err;
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("frames come again"), HasSubstr("reopened 1 times")));
  const std::string text = read_file(part_ / "rows.csv");
  EXPECT_EQ(text.back(), '\n');
  std::uint64_t last = 0;
  bool first = true;
  for (const auto& row : csv_rows(text)) {
    const std::uint64_t frame = std::stoull(row.at("frame"));
    EXPECT_TRUE(first || frame > last) << frame;
    last = frame;
    first = false;
  }
}

TEST_F(LiveGige, AnAbsentCameraIsGivenUpWhenToldToAndWrongSettingsAtOnce) {
  const Outcome absent = vsfind(live({"--source", "gige:127.0.0.1", "--give-up-after", "0.3"}));
  EXPECT_EQ(absent.code, 4);
  EXPECT_THAT(absent.err, AllOf(HasSubstr("gige:127.0.0.1: no camera answers"), HasSubstr("given up after 0.3 s")));
  const GigeServer camera(server("127.0.0.1", "40"));
  const Outcome wrong = vsfind(live({"--source", "gige:127.0.0.1", "--control", "Nonsense=1"}));
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.err, HasSubstr("feature Nonsense"));
}

TEST_F(LiveGige, LostPacketsGiveBadFrameRows) {
  auto words = server("127.0.0.1", "40");
  words.insert(words.end(), {"--lost", "0.02"});
  const GigeServer camera(words);
  const Outcome outcome = vsfind(live({"--source", "gige:127.0.0.1", "--frames", "40", "--packet-size", "1500",
                                       "--packet-resend", "off", "--record", part_ / "rec.y4m"}));
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const auto rows = csv_rows(outcome.out);
  ASSERT_EQ(rows.size(), 40U);
  const auto bad =
      std::count_if(rows.begin(), rows.end(), [](const Row& row) { return row.at("status") == "bad_frame"; });
  EXPECT_GT(bad, 5);
  expect_replayed(rows);
  std::size_t told = 0;
  for (const auto& line : lines_of(outcome.err))
    told += line.find("incomplete or corrupt") != std::string::npos ? 1 : 0;
  EXPECT_EQ(told, 1U) << outcome.err;
  const auto again = csv_rows(vsfind({"replay", part_ / "rec.y4m", "--model", part_.model()}).out);
  ASSERT_EQ(again.size(), rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) EXPECT_EQ(bare(again[i]), bare(rows[i]));
}

// A camera that shows the recording of a stage gives the figures that the recording gives.
TEST_F(LiveGige, QualifyTakesItsStepsFromACamera) {
  const auto simulated =
      vsfind({"qualify", "--simulate", "--accuracy", "10", "--steps", "8", "--images", part_.path()});
  ASSERT_EQ(simulated.code, 0) << simulated.err;
  const std::string model = part_ / "bullseye.vsm";
  ASSERT_EQ(vsfind({"train", part_ / "training.png", "--roi", "224,144,191,191", "--accuracy", "10", "-o", model}).code,
            0);
  const GigeServer camera({"127.0.0.1", "S1", "640x480", "10", "--frames", part_ / "linear.y4m"});
  const auto measured = [&](std::vector<std::string> more, const std::string& folder) {
    more.insert(more.begin(), {"qualify", "gige:127.0.0.1", "--model", model, "--report", part_ / folder});
    const Outcome outcome = vsfind(more);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("Translation test: 16 images"));
    return csv_rows(read_file(part_ / (folder + "/measured.csv")));
  };
  const Outcome recorded = vsfind({"qualify", part_ / "linear.y4m", "--model", model, "--report", part_ / "recorded"});
  ASSERT_EQ(recorded.code, 0) << recorded.err;
  std::set<std::string> places;
  for (const auto& row : csv_rows(read_file(part_ / "recorded/measured.csv"))) places.insert(row.at("y"));
  ASSERT_EQ(places.size(), 8U);
  // Twice round the recording: every frame is one of the recording's, and all of them come.
  std::set<std::string> seen;
  const auto rows = measured({"--frames", "16"}, "live");
  ASSERT_EQ(rows.size(), 16U);
  for (const auto& row : rows) {
    EXPECT_TRUE(places.contains(row.at("y"))) << row.at("y");
    seen.insert(row.at("y"));
  }
  EXPECT_EQ(seen.size(), 8U);
  const auto timed = measured({"--frames", "16", "--take", "0.15"}, "timed");
  ASSERT_EQ(timed.size(), 16U);
  for (std::size_t i = 0; i < timed.size(); ++i) {
    EXPECT_EQ(timed[i].at("frame"), std::to_string(i));
    EXPECT_TRUE(places.contains(timed[i].at("y"))) << timed[i].at("y");
  }
  const auto refused = [&](std::vector<std::string> more, const std::string& what) {
    more.insert(more.begin(), {"qualify", "--model", model});
    const Outcome outcome = vsfind(more);
    EXPECT_EQ(outcome.code, 2);
    EXPECT_THAT(outcome.err, HasSubstr(what));
  };
  refused({"gige:127.0.0.1"}, "gige:127.0.0.1: --frames is needed of a camera");
  refused({part_ / "linear.y4m", "--take", "enter"}, "--take needs a camera");
  refused({"gige:127.0.0.1", "--frames", "5", "--take", "soon"}, "allowed: every, enter, or seconds");
}

}  // namespace
}  // namespace vsfind::test
