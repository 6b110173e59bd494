/// The shipped interlaced sequence, trained and searched: in this process, and by the program itself.
#include "render/sequence.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <memory>
#include <string>

#include "acquisition/image_file.h"
#include "acquisition/source.h"
#include "csv.h"
#include "finder/search.h"
#include "finder/train.h"

namespace vsfind {
namespace {

const std::string folder = VSFIND_TEST_DATA "/interlaced";

constexpr double x_tolerance = 0.1;        // px
constexpr double y_tolerance = 0.2;        // px
constexpr double angle_tolerance = 0.1;    // degrees
constexpr double parity_tolerance = 0.02;  // px, of the mean y errors of the two fields

/// Sums the y errors of each field, to compare the means.
struct ParityCheck {
  double sum[2] = {0.0, 0.0};
  int count[2] = {0, 0};
  void add(bool bottom, double error) {
    sum[bottom ? 1 : 0] += error;
    ++count[bottom ? 1 : 0];
  }
  void expect_no_half_line_offset() const {
    ASSERT_GT(count[0], 0);
    ASSERT_GT(count[1], 0);
    EXPECT_LT(std::abs(sum[0] / count[0] - sum[1] / count[1]), parity_tolerance);
  }
};

struct Truth {
  bool present = false;
  double x = 0.0, y = 0.0, angle_deg = 0.0;
};

std::map<std::string, Truth> load_truth() {
  std::map<std::string, Truth> truth;
  for (test::CsvRow& row : test::read_csv(folder + "/truth.csv")) {
    Truth& t = truth[row["frame"] + row["field"]];
    t.present = !row["x"].empty();
    if (t.present) t = {true, std::stod(row["x"]), std::stod(row["y"]), std::stod(row["angle_deg"])};
  }
  return truth;
}

TEST(Sequence, EveryFieldIsFoundWhereItWasRendered) {
  const Image training = load_image(folder + "/training.png");
  TrainOptions options;
  options.roi = render::sequence_roi;
  options.angle_deg = {-30.0, 30.0};
  Finder finder({std::make_shared<const Pattern>(train(training.view(), Mapping(), options))}, {});
  const auto truth = load_truth();
  const auto source = open_sequence(folder + "/conveyor.y4m");
  ParityCheck parity;
  int found = 0;
  int frames = 0;
  while (auto frame = source->next()) {
    for (const Field field : {Field::top, Field::bottom}) {
      const auto& matches = finder.find(field_view(frame->image(), field), Mapping().for_field(field)).front().matches;
      const std::string key = std::to_string(frame->info().sequence) + name(field);
      ASSERT_TRUE(truth.count(key)) << key;
      const Truth& expected = truth.at(key);
      EXPECT_EQ(matches.size(), expected.present ? 1U : 0U) << key;
      if (matches.empty() || !expected.present) continue;
      ++found;
      const Match& match = matches.front();
      EXPECT_NEAR(match.pose.x, expected.x, x_tolerance) << key;
      EXPECT_NEAR(match.pose.y, expected.y, y_tolerance) << key;
      EXPECT_NEAR(match.pose.angle_deg, expected.angle_deg, angle_tolerance) << key;
      EXPECT_NEAR(match.frame_position.y(), match.pose.y, 1e-9) << key;
      parity.add(field == Field::bottom, match.pose.y - expected.y);
    }
    ++frames;
  }
  EXPECT_EQ(frames, render::sequence_frames);
  EXPECT_EQ(found, 2 * (render::sequence_frames - 1));
  parity.expect_no_half_line_offset();
}

/// Runs the program; its exit code.
int run(const std::string& arguments) {
  const int status = std::system(("\"" VSFIND_PROGRAM "\" " + arguments + " 2>/dev/null").c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

class SequenceByProgram : public ::testing::Test {
 protected:
  /// Once for all the tests here.
  static void SetUpTestSuite() {
    trained_ = run("train \"" + folder + "/training.png\" --roi 245,175,151,131 --angle -30:30 -o \"" + model_ +
                   "\" >/dev/null") == 0;
  }
  /// Replays, and returns the rows.
  static std::vector<test::CsvRow> replay(const std::string& label, const std::string& more) {
    const std::string csv = temp_ + label + ".csv";
    const int code = run("replay \"" + folder + "/conveyor.y4m\" --model \"" + model_ + "\" --field split --csv \"" +
                         csv + "\" " + more + " >/dev/null");
    EXPECT_EQ(code, 0);
    return test::read_csv(csv);
  }
  static inline const std::string temp_ = ::testing::TempDir() + "vsfind_sequence_" + std::to_string(getpid()) + "_";
  static inline const std::string model_ = temp_ + "part.vsfind";
  static inline bool trained_ = false;
};

TEST_F(SequenceByProgram, RowsAreTheTruth) {
  ASSERT_TRUE(trained_);
  auto truth = load_truth();
  std::vector<test::CsvRow> rows = replay("truth", "");
  EXPECT_EQ(rows.size(), truth.size());
  ParityCheck parity;
  bool top = true;
  for (test::CsvRow& row : rows) {
    ASSERT_FALSE(row.count("")) << row[""];
    EXPECT_EQ(row["field"], top ? "top" : "bottom") << "the earlier field first";
    top = !top;
    const std::string key = row["frame"] + row["field"];
    const auto entry = truth.find(key);
    ASSERT_NE(entry, truth.end()) << key << " twice, or never rendered";
    const Truth expected = entry->second;
    truth.erase(entry);
    EXPECT_EQ(row["status"], expected.present ? "found" : "not_found") << key;
    if (!expected.present || row["status"] != "found") {
      EXPECT_EQ(row["x"], "") << key;
      continue;
    }
    EXPECT_EQ(row["unit"], "px");
    EXPECT_NEAR(std::stod(row["x"]), expected.x, x_tolerance) << key;
    EXPECT_NEAR(std::stod(row["y"]), expected.y, y_tolerance) << key;
    EXPECT_NEAR(std::stod(row["angle_deg"]), expected.angle_deg, angle_tolerance) << key;
    EXPECT_NEAR(std::stod(row["image_y"]), std::stod(row["y"]), 0.001) << key;
    parity.add(row["field"] == "bottom", std::stod(row["y"]) - expected.y);
  }
  EXPECT_TRUE(truth.empty()) << truth.size() << " fields have no row";
  parity.expect_no_half_line_offset();
}

TEST_F(SequenceByProgram, RowsAreTheSameAgainAndWithMoreThreads) {
  ASSERT_TRUE(trained_);
  const auto without_times = [](std::vector<test::CsvRow> rows) {
    for (test::CsvRow& row : rows) {
      row.erase("search_ms");
      row.erase("latency_ms");
    }
    return rows;
  };
  const auto first = without_times(replay("first", "--threads 1"));
  ASSERT_FALSE(first.empty());
  EXPECT_EQ(without_times(replay("again", "--threads 1")), first);
  EXPECT_EQ(without_times(replay("threads", "--threads 2")), first);
}

}  // namespace
}  // namespace vsfind
