/// `evaluate` and the report of a run: judging, the file of truth, the command from outside.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "acquisition/errors.h"
#include "app/evaluate/judge.h"
#include "app/evaluate/truth_file.h"
#include "tests/app/shell.h"

namespace vsfind {
namespace {

/// Each text stands in the page, and nothing is fetched from elsewhere. (A page has megabytes: a matcher would print
/// it.)
void expect_in(const std::string& page, const std::vector<std::string>& texts) {
  for (const auto& text : texts) EXPECT_NE(page.find(text), std::string::npos) << text;
  for (const char* text : {"http:", "https:", "<script"}) EXPECT_EQ(page.find(text), std::string::npos) << text;
}

using testing::AllOf;
using testing::HasSubstr;

Match match_at(double x, double y, double angle_deg = 0.0) {
  Match match;
  match.pose = {x, y, angle_deg, 1.0, 1.0};
  match.frame_position = {x + 100.0, y};
  match.score = 0.9;
  return match;
}

TruthRow truth_at(double x, double y, std::optional<double> angle_deg = {}) {
  TruthRow row;
  row.present = true;
  row.x = x;
  row.y = y;
  row.angle_deg = angle_deg;
  return row;
}

TEST(Judge, NearestPairsFirstEachOnce) {
  const auto judged = judge_picture({match_at(10.9, 10), match_at(10.1, 10), match_at(50, 50)},
                                    {truth_at(10, 10), truth_at(11, 10), truth_at(90, 90)}, false, {2.0, 2.0});
  ASSERT_EQ(judged.size(), 4U);
  EXPECT_EQ(judged[0].verdict, Verdict::right);
  EXPECT_EQ(judged[1].verdict, Verdict::right);
  EXPECT_NEAR(std::abs(judged[0].error_x), 0.1, 1e-9);
  EXPECT_NEAR(std::abs(judged[1].error_x), 0.1, 1e-9);
  EXPECT_EQ(judged[2].verdict, Verdict::missed);
  EXPECT_EQ(judged[2].truth->x, 90.0);
  EXPECT_EQ(judged[3].verdict, Verdict::false_alarm);
  EXPECT_EQ(judged[3].match->pose.x, 50.0);
}

TEST(Judge, AnglesGoRoundAndCount) {
  const auto right = judge_picture({match_at(0, 0, 179.5)}, {truth_at(0, 0, -179.5)}, false, {2.0, 2.0});
  ASSERT_EQ(right.size(), 1U);
  EXPECT_NEAR(*right[0].error_angle_deg, -1.0, 1e-9);
  const auto wrong = judge_picture({match_at(0, 0, 10.0)}, {truth_at(0, 0, 0.0)}, false, {2.0, 2.0});
  ASSERT_EQ(wrong.size(), 2U);
  EXPECT_EQ(wrong[0].verdict, Verdict::missed);
  EXPECT_EQ(wrong[1].verdict, Verdict::false_alarm);
}

TEST(Judge, InFramePixels) {
  EXPECT_EQ(judge_picture({match_at(1, 2)}, {truth_at(101, 2)}, true, {0.1, 2.0}).front().verdict, Verdict::right);
  EXPECT_EQ(judge_picture({match_at(1, 2)}, {truth_at(101, 2)}, false, {0.1, 2.0}).front().verdict, Verdict::missed);
}

TEST(TruthFile, HandMarkedAndOwnResults) {
  const TruthFile marked = parse_truth("# by hand\nframe,image_x,image_y\n3,1.5,2\n\n4,,\n", "m.csv");
  EXPECT_TRUE(marked.in_frame_pixels);
  ASSERT_EQ(marked.rows.size(), 2U);
  EXPECT_TRUE(marked.rows[0].present);
  EXPECT_EQ(marked.rows[0].frame, 3U);
  EXPECT_FALSE(marked.rows[0].field.has_value());
  EXPECT_FALSE(marked.rows[1].present);
  const TruthFile results = parse_truth(
      "\xef\xbb\xbfsource,frame,field,model,status,x,y,angle_deg,scale_x,image_x,image_y\r\n"
      "\"a,\"\"b\"\".y4m\",18446744073709551615,bottom,part,found,1,2,-3,1.01,5,6\r\n"
      "a,7,top,part,not_found,,,,,,\r\n",
      "r.csv");
  EXPECT_FALSE(results.in_frame_pixels);
  ASSERT_EQ(results.rows.size(), 2U);
  EXPECT_EQ(results.rows[0].frame, 18446744073709551615U);
  EXPECT_EQ(results.rows[0].field, Field::bottom);
  EXPECT_EQ(results.rows[0].model, "part");
  EXPECT_EQ(results.rows[0].angle_deg, -3.0);
  EXPECT_EQ(results.rows[0].scale_x, 1.01);
  EXPECT_FALSE(results.rows[0].scale_y.has_value());
  EXPECT_FALSE(results.rows[1].present);
}

TEST(TruthFile, ComplaintsNameLineAndColumn) {
  const auto complaint = [](const std::string& text) -> std::string {
    try {
      static_cast<void>(parse_truth(text, "t.csv"));
    } catch (const UsageError& error) {
      return error.what();
    }
    return "taken";
  };
  EXPECT_THAT(complaint(""), HasSubstr("t.csv: is empty"));
  EXPECT_THAT(complaint("frame,x\n1,2\n"), AllOf(HasSubstr("t.csv:1:"), HasSubstr("are needed")));
  EXPECT_THAT(complaint("frame,x,y\n1,2,3\nx,2,3\n"), HasSubstr("t.csv:3: frame: 'x' is not the number"));
  EXPECT_THAT(complaint("frame,x,y\n-1,2,3\n"), HasSubstr("frame"));
  EXPECT_THAT(complaint("frame,x,y\n1,2,\n"), HasSubstr("t.csv:2: y: is missing"));
  EXPECT_THAT(complaint("frame,x,y\n1,nan,3\n"), HasSubstr("x: 'nan' is not a number"));
  EXPECT_THAT(complaint("frame,x,y,field\n1,2,3,left\n"), HasSubstr("allowed: frame, top, bottom"));
  EXPECT_THAT(complaint("frame,x,y,x\n1,2,3,4\n"), HasSubstr("stands twice"));
}

class EvaluateCommand : public testing::Test {
 protected:
  EvaluateCommand() {
    const auto outcome = test::vsfind({"train", data_ + "/training.png", "--roi", "245,175,151,131", "--angle",
                                       "-30:30", "--name", "part", "-o", folder_ / "part.vsm"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
  }
  std::string data_ = std::string(VSFIND_TEST_DATA) + "/interlaced";
  test::TemporaryFolder folder_;
};

TEST_F(EvaluateCommand, ShippedRecordingAgainstItsTruthAndTheReports) {
  const std::string recording = data_ + "/conveyor.y4m";
  const std::string model = folder_ / "part.vsm";
  const auto judged = test::vsfind({"evaluate", recording, "--truth", data_ + "/truth.csv", "--model", model, "--field",
                                    "split", "--report", folder_ / "judged", "--csv", folder_ / "judged.csv"});
  ASSERT_EQ(judged.code, 0) << judged.err;
  EXPECT_THAT(judged.out, AllOf(HasSubstr("50 (100.00 %)"), HasSubstr("angle deg")));
  const auto rows = test::csv_rows(test::read_file(folder_ / "judged.csv"));
  EXPECT_EQ(rows.size(), 50U);
  for (auto row : rows) {
    EXPECT_EQ(row["verdict"], "right");
    EXPECT_LT(std::abs(std::stod(row["error_x"])), 0.1);
  }
  const std::string html = test::read_file(folder_ / "judged/report.html");
  expect_in(html, {"50 of 50", "data:image/jpeg;base64,"});

  // What replay writes is itself a list of truth; shifted by 5 px every line is a miss and a false alarm.
  const auto replayed = test::vsfind({"replay", recording, "--model", model, "--field", "split", "--csv",
                                      folder_ / "rows.csv", "--report", folder_ / "run"});
  ASSERT_EQ(replayed.code, 0) << replayed.err;
  const auto same = test::vsfind({"evaluate", recording, "--truth", folder_ / "rows.csv", "--model", model, "--field",
                                  "split", "--max-error", "0.00001"});
  EXPECT_THAT(same.out, HasSubstr("50 (100.00 %)"));
  std::string shifted = "frame,field,x,y\n";
  for (auto row : test::csv_rows(test::read_file(folder_ / "rows.csv"))) {
    shifted += row["frame"] + "," + row["field"] + ",";
    shifted += row["x"].empty() ? "," : std::to_string(std::stod(row["x"]) + 5.0) + "," + row["y"];
    shifted += "\n";
  }
  test::write_file(folder_ / "shifted.csv", shifted);
  const auto wrong = test::vsfind(
      {"evaluate", recording, "--truth", folder_ / "shifted.csv", "--model", model, "--field", "split", "--csv", "-"});
  ASSERT_EQ(wrong.code, 0) << wrong.err;
  std::map<std::string, int> verdicts;
  for (auto row : test::csv_rows(wrong.out)) ++verdicts[row["verdict"]];
  EXPECT_EQ(verdicts, (std::map<std::string, int>{{"missed", 50}, {"false_alarm", 50}}));

  const std::string run = test::read_file(folder_ / "run/report.html");
  expect_in(run, {"not found in 2 pictures", "frame 13, top field", "Latency", "Weakest matches"});
  for (const char* chart : {"score", "x", "y", "angle", "latency", "search"}) {
    EXPECT_TRUE(std::filesystem::exists(folder_ / (std::string("run/") + chart + ".png"))) << chart;
  }
}

TEST_F(EvaluateCommand, RefusesInOneLine) {
  const std::string recording = data_ + "/conveyor.y4m";
  const auto refused = [](const std::vector<std::string>& arguments, int code, const std::string& what) {
    const auto outcome = test::vsfind(arguments);
    EXPECT_EQ(outcome.code, code) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(what));
    EXPECT_EQ(test::lines_of(outcome.err).size(), 1U) << outcome.err;
  };
  const std::string model = folder_ / "part.vsm";
  refused({"evaluate", recording, "--model", model}, 2, "--truth is needed");
  refused({"evaluate", recording, "--truth", data_ + "/truth.csv"}, 2, "--model is needed");
  refused({"evaluate", recording, "--truth", data_ + "/none.csv", "--model", model}, 3, "none.csv: cannot be read");
  refused({"evaluate", recording, "--truth", data_ + "/training.png", "--model", model}, 2, "training.png");
  test::write_file(folder_ / "file", "x");
  refused({"replay", recording, "--model", model, "--report", folder_ / "file"}, 3, "file");
}

}  // namespace
}  // namespace vsfind
