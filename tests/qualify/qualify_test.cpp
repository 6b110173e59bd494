/// `qualify` from its command line to its report.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <opencv2/imgcodecs.hpp>

#include "app/report/chart.h"
#include "app/report/spread.h"
#include "tests/app/shell.h"

namespace vsfind {
namespace {

/// Each text stands in the page, and nothing is fetched from elsewhere. (A page has megabytes: a matcher would print
/// it.)
void expect_in(const std::string& page, const std::vector<std::string>& texts) {
  for (const auto& text : texts) EXPECT_NE(page.find(text), std::string::npos) << text;
  for (const char* text : {"http:", "https:", "<script"}) EXPECT_EQ(page.find(text), std::string::npos) << text;
}

using test::csv_rows;
using test::read_file;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

using Rows = std::vector<std::map<std::string, std::string>>;

double sd_against_truth(const Rows& rows, const std::string& test, const std::string& column) {
  std::vector<double> errors;
  for (auto row : rows) {
    if (row["test"] == test) errors.push_back(std::stod(row[column]) - std::stod(row["true_" + column]));
  }
  return spread_of(errors).sd;
}

std::string without_times(const std::map<std::string, std::string>& row) {
  std::string text;
  for (const auto& [column, value] : row) {
    if (column != "search_ms" && column.rfind("true_", 0) != 0) text += column + "=" + value + " ";
  }
  return text;
}

/// One simulated experiment for all that follows: it takes seconds, and every test is a process of its own.
class Experiment {
 public:
  Experiment()
      : simulated_(test::vsfind({"qualify", "--simulate", "--accuracy", "20,30", "--steps", "8", "--report",
                                 folder_ / "report", "--images", folder_ / "images"})) {}

  void simulation_is_as_exact_as_its_table_says() const;
  void report_is_complete_in_itself() const;
  void recorded_pictures_give_the_same_rows() const;
  void rotary_stage_with_regions_and_two_models() const;
  void without_fiducials_the_travel_alone_is_judged() const;
  void refuses_in_one_line() const;

 private:
  [[nodiscard]] std::string file(const std::string& name) const { return folder_ / name; }
  [[nodiscard]] std::string trained(const std::string& name, const std::string& angles) const {
    const auto outcome = test::vsfind({"train", file("images/training.png"), "--roi", "224,144,191,191", "--accuracy",
                                       "30", "--angle", angles, "--name", "bullseye", "-o", file(name)});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return file(name);
  }
  test::TemporaryFolder folder_;
  test::Outcome simulated_;
};

void Experiment::simulation_is_as_exact_as_its_table_says() const {
  ASSERT_EQ(simulated_.code, 0) << simulated_.err;
  EXPECT_EQ(simulated_.err, "");
  EXPECT_THAT(simulated_.out, AllOf(HasSubstr("Translation test: 8 images, steps of 0.333"),
                                    HasSubstr("Rotation test: 8 images, steps of 0.4"), HasSubstr("8/8"),
                                    HasSubstr("relative to the fiducials (8 of 8 images)")));
  const Rows rows = csv_rows(read_file(file("report/measured.csv")));
  ASSERT_EQ(rows.size(), 16U);
  for (auto row : rows) {
    EXPECT_EQ(row["found"], "1");
    EXPECT_NEAR(std::stod(row["noise"]), 2.02, 0.06);
    EXPECT_NE(row["fiducial_x"], "");
  }
  // The published experiment reached 0.011 px, and 0.023 px with rotation.
  EXPECT_LT(sd_against_truth(rows, "linear", "x"), 0.003);
  EXPECT_LT(sd_against_truth(rows, "linear", "y"), 0.003);
  EXPECT_LT(sd_against_truth(rows, "rotary", "x"), 0.004);
  EXPECT_LT(sd_against_truth(rows, "rotary", "y"), 0.004);
  EXPECT_LT(sd_against_truth(rows, "rotary", "angle_deg"), 0.004);
}

void Experiment::report_is_complete_in_itself() const {
  const std::string html = read_file(file("report/report.html"));
  expect_in(html, {"<!DOCTYPE html>", "</html>", "data:image/png;base64,", "Cramér", "seed"});
  for (const char* name : {"linear-pattern", "linear-fiducials", "linear-relative", "rotary-pattern",
                           "rotary-fiducials", "rotary-relative", "rotary-relative-angle"}) {
    const cv::Mat chart = cv::imread(file("report/") + name + ".png", cv::IMREAD_COLOR);
    ASSERT_FALSE(chart.empty()) << name;
    EXPECT_EQ(chart.size(), cv::Size(chart_width, chart_height)) << name;
  }
}

void Experiment::recorded_pictures_give_the_same_rows() const {
  const std::string model = trained("linear.vsm", "0:0");
  const auto recorded =
      test::vsfind({"qualify", file("images/linear.y4m"), "--model", model, "--report", file("again")});
  ASSERT_EQ(recorded.code, 0) << recorded.err;
  const Rows first = csv_rows(read_file(file("report/measured.csv")));
  const Rows again = csv_rows(read_file(file("again/measured.csv")));
  ASSERT_EQ(again.size(), 8U);
  for (std::size_t i = 0; i < again.size(); ++i) EXPECT_EQ(without_times(again[i]), without_times(first[i]));
}

void Experiment::rotary_stage_with_regions_and_two_models() const {
  const std::string wide = trained("wide.vsm", "-45:45");
  const std::string narrow = trained("narrow.vsm", "-5:5");
  const auto outcome =
      test::vsfind({"qualify", file("images/rotary.y4m"), "--stage", "rotary", "--model", wide, "--model", narrow,
                    "--fiducials", "10,10,90,90", "--fiducials", "540,380,90,90", "--report", file("rotary")});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("Rotation test: 8 images"));
  const auto rows = csv_rows(read_file(file("rotary/measured.csv")));
  ASSERT_EQ(rows.size(), 8U);
  for (auto row : rows) EXPECT_NEAR(std::stod(row["fiducial_x"]), 320.0, 5.0);
}

void Experiment::without_fiducials_the_travel_alone_is_judged() const {
  const std::string model = trained("alone.vsm", "0:0");
  const auto outcome = test::vsfind({"qualify", file("images/linear.y4m"), "--model", model, "--fiducials", "none"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("as there are no fiducials"), Not(HasSubstr("relative to fiducials"))));
}

void Experiment::refuses_in_one_line() const {
  const std::string model = trained("refused.vsm", "0:0");
  const auto refused = [](std::vector<std::string> arguments, int code, const std::string& what) {
    arguments.insert(arguments.begin(), "qualify");
    const auto outcome = test::vsfind(arguments);
    EXPECT_EQ(outcome.code, code) << outcome.err;
    EXPECT_THAT(outcome.err, AllOf(testing::StartsWith("vsfind: "), HasSubstr(what)));
    EXPECT_EQ(test::lines_of(outcome.err).size(), 1U) << outcome.err;
  };
  const std::string sequence = file("images/linear.y4m");
  refused({}, 2, "SEQUENCE or --simulate");
  refused({sequence}, 2, "--model is needed");
  refused({sequence, "--simulate"}, 2, "--simulate cannot be given together");
  refused({sequence, "--model", model, "--accuracy", "10"}, 2, "--accuracy needs --simulate");
  refused({"--simulate", "--accuracy", "0,10"}, 2, "--accuracy");
  refused({sequence, "--model", model, "--fiducials", "10,10,90,90"}, 2, "one region alone");
  refused({sequence, "--model", model, "--fiducials", "10,10,90,90", "--fiducials", "300,60,20,20"}, 2,
          "--fiducials 300,60,20,20: there is no square");
  refused({file("images/missing.y4m"), "--model", model}, 3, "missing.y4m");
}

TEST(Qualify, SimulatedExperimentItsReportAndItsRecordings) {
  const Experiment experiment;
  experiment.simulation_is_as_exact_as_its_table_says();
  if (HasFatalFailure()) return;
  experiment.report_is_complete_in_itself();
  experiment.recorded_pictures_give_the_same_rows();
  experiment.rotary_stage_with_regions_and_two_models();
  experiment.without_fiducials_the_travel_alone_is_judged();
  experiment.refuses_in_one_line();
}

/// The closing tables of a simulation: test, accuracy and column, as "Rotation 30 bound px".
std::map<std::string, double> closing_tables(const std::string& text) {
  std::map<std::string, double> values;
  std::string test;
  std::vector<std::string> header;
  for (const std::string& line : test::lines_of(text)) {
    if (!line.empty() && line[0] != ' ') test = line.substr(0, line.find(' '));
    std::vector<std::string> cells;  // at least two blanks lie between two of them
    for (std::size_t at = line.find_first_not_of(' '); at != std::string::npos;) {
      const std::size_t end = line.find("  ", at);
      cells.push_back(line.substr(at, end == std::string::npos ? end : end - at));
      at = end == std::string::npos ? end : line.find_first_not_of(' ', end);
    }
    if (cells.size() > 5 && cells[0] == "accuracy") header = cells;
    if (header.empty() || cells.size() != header.size() || cells[0] == "accuracy") continue;
    for (std::size_t i = 3; i < cells.size(); ++i) {
      std::string key = test;
      key += ' ' + cells[0] + ' ' + header[i];
      values[key] = std::stod(cells[i]);
    }
  }
  return values;
}

TEST(Qualify, FromAccuracyThirtyOnTheErrorIsLessThanTwiceWhatTheNoiseAllows) {
  const auto outcome = test::vsfind({"qualify", "--simulate", "--accuracy", "30,60,100"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  auto values = closing_tables(outcome.out);
  for (const std::string row :
       {"Translation 30 ", "Translation 60 ", "Translation 100 ", "Rotation 30 ", "Rotation 60 ", "Rotation 100 "}) {
    for (const std::string unit : {"px", "deg"}) {
      if (row[0] == 'T' && unit == "deg") continue;
      ASSERT_TRUE(values.contains(row + "true S.D. " + unit)) << row << outcome.out;
      EXPECT_LT(values[row + "true S.D. " + unit], 2.0 * values[row + "bound " + unit]) << row << unit;
      EXPECT_GT(values[row + "true S.D. " + unit], 0.7 * values[row + "bound " + unit]) << row << unit;
    }
  }
}

}  // namespace
}  // namespace vsfind
