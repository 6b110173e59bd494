/// What bounds a search: its timeout and its coarse acceptance.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/app/scene.h"

namespace vsfind::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class SearchLimits : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(part_.training().code, 0) << part_.training().err;
    cv::Mat many;
    cv::repeat(scene(100, 80), 4, 4, many);
    cv::imwrite(part_ / "many.png", many);
  }
  [[nodiscard]] Outcome find(const std::string& picture, std::vector<std::string> more) const {
    std::vector<std::string> all{"find", part_ / picture, "--model", part_.model()};
    all.insert(all.end(), more.begin(), more.end());
    return vsfind(all);
  }
  TrainedPart part_;
};

TEST_F(SearchLimits, ASearchCutShortIsMarked) {
  const Outcome outcome = find(
      "many.png", {"--max-instances", "0", "--timeout-ms", "0.001", "--csv", "-", "--jsonl", part_ / "rows.jsonl"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const auto rows = csv_rows(outcome.out);
  ASSERT_FALSE(rows.empty());
  EXPECT_LT(rows.size(), 16U);
  for (const auto& row : rows) EXPECT_EQ(row.at("timed_out"), "1");
  EXPECT_EQ(nlohmann::json::parse(lines_of(read_file(part_ / "rows.jsonl")).at(0)).at("timed_out"), true);
  EXPECT_THAT(outcome.err, HasSubstr(", 1 timed out"));
}

TEST_F(SearchLimits, AWholeSearchIsNotMarked) {
  for (const std::string timeout : {"0", "600000"}) {
    const Outcome outcome = find("many.png", {"--max-instances", "0", "--timeout-ms", timeout});
    const auto rows = csv_rows(outcome.out);
    EXPECT_EQ(rows.size(), 16U) << outcome.err;
    for (const auto& row : rows) EXPECT_EQ(row.at("timed_out"), "0");
    EXPECT_THAT(outcome.err, testing::Not(HasSubstr("timed out")));
  }
}

TEST_F(SearchLimits, CandidatesBelowTheCoarseAcceptanceAreNotFollowed) {
  cv::Mat hidden = scene(131, 97);
  cv::rectangle(hidden, {131, 97, part_side, part_side * 3 / 10}, cv::Scalar(128), cv::FILLED);
  cv::imwrite(part_ / "hidden.png", hidden);
  const auto status = [&](const std::string& least) {
    const auto rows = csv_rows(find("hidden.png", {"--min-score", "0.4", "--coarse-score", least}).out);
    return rows.empty() ? std::string() : rows[0].at("status");
  };
  EXPECT_EQ(status("0.2"), "found");
  EXPECT_EQ(status("0.97"), "not_found");
}

TEST_F(SearchLimits, BadValuesAreNamedWithTheirBounds) {
  const Outcome score = find("many.png", {"--coarse-score", "1.5"});
  EXPECT_EQ(score.code, 2);
  EXPECT_THAT(score.err, AllOf(HasSubstr("coarse-score"), HasSubstr("0 to 1")));
  const Outcome timeout = find("many.png", {"--timeout-ms", "-1"});
  EXPECT_EQ(timeout.code, 2);
  EXPECT_THAT(timeout.err, AllOf(HasSubstr("timeout-ms"), HasSubstr("allowed")));
}

}  // namespace
}  // namespace vsfind::test
