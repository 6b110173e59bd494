#include <gmock/gmock.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "tests/app/scene.h"

namespace vsfind::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

class Program : public testing::Test {
 protected:
  void SetUp() override { ASSERT_EQ(part_.training().code, 0) << part_.training().err; }
  TrainedPart part_;
};

TEST(ProgramHelp, EveryCommandHasUnitsAndAnExample) {
  const Outcome top = vsfind({"--help"});
  EXPECT_EQ(top.code, 0);
  EXPECT_EQ(top.err, "");
  for (const std::string command : {"train", "find", "replay", "inspect"}) {
    EXPECT_THAT(top.out, HasSubstr("\n  " + command + " "));
    const Outcome help = vsfind({command, "--help"});
    EXPECT_EQ(help.code, 0);
    EXPECT_THAT(help.out, AllOf(HasSubstr("Example: vsfind " + command), HasSubstr("Usage: vsfind " + command)));
    EXPECT_THAT(help.out, AllOf(HasSubstr("pixels"), HasSubstr("--verbose")));
    for (const auto& line : lines_of(help.out)) EXPECT_LE(line.size(), 120U) << line;
  }
  EXPECT_THAT(vsfind({"train", "--help"}).out, HasSubstr("degrees"));
  EXPECT_THAT(vsfind({"find", "--help"}).out, AllOf(HasSubstr("degrees"), HasSubstr("milliseconds")));
}

TEST(ProgramHelp, Version) {
  const Outcome version = vsfind({"--version"});
  EXPECT_EQ(version.code, 0);
  EXPECT_THAT(version.out, StartsWith("vsfind "));
}

TEST_F(Program, TrainingReportsPointsPerLevelTimeAndAccuracy) {
  const std::string& report = part_.training().out;
  EXPECT_THAT(report,
              AllOf(HasSubstr("pattern      part\n"), HasSubstr("exhaustive search"), HasSubstr("level 0:"),
                    HasSubstr("sub-pixel pose"), HasSubstr("impostor"), HasSubstr("trained in"), HasSubstr("S.D. x")));
}

TEST_F(Program, FindsThePartWhereItIs) {
  cv::imwrite(part_ / "a.png", scene(131, 97));
  cv::imwrite(part_ / "b.png", scene_without_part());
  const Outcome outcome = vsfind({"find", part_ / "a.png", part_ / "b.png", "--model", part_.model()});
  EXPECT_EQ(outcome.code, 0);
  const auto rows = csv_rows(outcome.out);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].at("source"), part_ / "a.png");
  EXPECT_EQ(rows[0].at("frame"), "0");
  EXPECT_EQ(rows[0].at("field"), "frame");
  EXPECT_EQ(rows[0].at("model"), "part");
  EXPECT_EQ(rows[0].at("status"), "found");
  EXPECT_EQ(rows[0].at("instance"), "0");
  // The centre of the ROI 131,97,80,80.
  EXPECT_NEAR(std::stod(rows[0].at("x")), 170.5, 0.02);
  EXPECT_NEAR(std::stod(rows[0].at("y")), 136.5, 0.02);
  EXPECT_NEAR(std::stod(rows[0].at("image_x")), 170.5, 0.02);
  EXPECT_EQ(rows[0].at("unit"), "px");
  EXPECT_GT(std::stod(rows[0].at("score")), 0.95);
  EXPECT_GT(std::stod(rows[0].at("search_ms")), 0.0);
  EXPECT_GE(std::stod(rows[0].at("latency_ms")), std::stod(rows[0].at("search_ms")));
  EXPECT_EQ(rows[1].at("frame"), "1");
  EXPECT_EQ(rows[1].at("status"), "not_found");
  EXPECT_EQ(rows[1].at("x"), "");
  EXPECT_NE(rows[1].at("search_ms"), "");
  EXPECT_THAT(outcome.err, AllOf(StartsWith("vsfind: 2 frames: 1 found, 1 not found, 0 bad"), HasSubstr("median"),
                                 HasSubstr("99th percentile"), HasSubstr("maximum")));
}

TEST_F(Program, OriginMovesThePosition) {
  const Outcome trained = vsfind({"train", part_ / "train.png", "--roi", roi_at(100, 80), "--origin", "100,80", "-o",
                                  part_ / "corner.vsm", "--name", "corner, upper left"});
  ASSERT_EQ(trained.code, 0) << trained.err;
  cv::imwrite(part_ / "a.png", scene(131, 97));
  const Outcome outcome = vsfind({"find", part_ / "a.png", "--model", part_ / "corner.vsm", "--jsonl", "-", "--quiet"});
  EXPECT_EQ(outcome.err, "");
  const auto row = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(row["model"], "corner, upper left");
  EXPECT_NEAR(row["x"].get<double>(), 131.0, 0.02);
  EXPECT_NEAR(row["y"].get<double>(), 97.0, 0.02);
}

TEST_F(Program, SplitSearchesBothFieldsInFrameCoordinates) {
  cv::imwrite(part_ / "a.png", scene(131, 97));
  const Outcome outcome =
      vsfind({"find", part_ / "a.png", "--model", part_.model(), "--field", "split", "--overlay", part_ / "o"});
  const auto rows = csv_rows(outcome.out);
  ASSERT_EQ(rows.size(), 2U) << outcome.err;
  EXPECT_EQ(rows[0].at("field"), "top");
  EXPECT_EQ(rows[1].at("field"), "bottom");
  for (const auto& row : rows) {
    EXPECT_EQ(row.at("status"), "found");
    EXPECT_NEAR(std::stod(row.at("x")), 170.5, 0.1);
    EXPECT_NEAR(std::stod(row.at("y")), 136.5, 0.2);
  }
  EXPECT_EQ(cv::imread(part_ / "o/s0-00000000-a-top.png").size(), cv::Size(scene_width, scene_height));
  EXPECT_FALSE(cv::imread(part_ / "o/s0-00000000-b-bottom.png").empty());
}

TEST_F(Program, AnImageCanBeASingleField) {
  const cv::Mat frame = scene(131, 97);
  cv::Mat field(scene_height / 2, scene_width, CV_8UC1);
  for (int y = 0; y < field.rows; ++y) frame.row(2 * y + 1).copyTo(field.row(y));
  cv::imwrite(part_ / "bottom.png", field);
  const Outcome outcome = vsfind({"find", part_ / "bottom.png", "--model", part_.model(), "--field", "bottom"});
  const auto rows = csv_rows(outcome.out);
  ASSERT_EQ(rows.size(), 1U) << outcome.err;
  EXPECT_EQ(rows[0].at("field"), "bottom");
  EXPECT_NEAR(std::stod(rows[0].at("y")), 136.5, 0.2);
}

TEST_F(Program, PixelAspectStretchesX) {
  const std::vector<std::string> aspect{"--pixel-aspect", "59:54"};
  const Outcome trained = vsfind(
      {"train", part_ / "train.png", "--roi", roi_at(100, 80), "-o", part_ / "pal.vsm", "--pixel-aspect", "pal"});
  ASSERT_EQ(trained.code, 0) << trained.err;
  cv::imwrite(part_ / "a.png", scene(131, 97));
  const Outcome outcome =
      vsfind({"find", part_ / "a.png", "--model", part_ / "pal.vsm", "--pixel-aspect", "59:54", "-v"});
  const auto rows = csv_rows(outcome.out);
  ASSERT_EQ(rows.size(), 1U) << outcome.err;
  EXPECT_NEAR(std::stod(rows[0].at("x")), 170.5 * 59.0 / 54.0, 0.03);
  EXPECT_NEAR(std::stod(rows[0].at("image_x")), 170.5, 0.03);
  EXPECT_THAT(outcome.err, HasSubstr("pixel aspect 59:54 as given"));
}

TEST_F(Program, SeveralModelsGiveARowEach) {
  const Outcome trained =
      vsfind({"train", part_ / "train.png", "--roi", "110,90,60,60", "-o", part_ / "inner.vsm", "--angle", "-5:5"});
  ASSERT_EQ(trained.code, 0) << trained.err;
  cv::imwrite(part_ / "a.png", scene(131, 97));
  const Outcome outcome = vsfind({"find", part_ / "a.png", "--model", part_.model(), "--model", part_ / "inner.vsm"});
  const auto rows = csv_rows(outcome.out);
  ASSERT_EQ(rows.size(), 2U) << outcome.err;
  EXPECT_EQ(rows[0].at("model"), "part");
  EXPECT_EQ(rows[1].at("model"), "inner");
  EXPECT_NEAR(std::stod(rows[1].at("x")), 170.5, 0.05);
}

TEST_F(Program, NegativeRangesAreValuesAndNotOptions) {
  ASSERT_EQ(vsfind({"train", part_ / "train.png", "--roi", roi_at(100, 80), "--angle", "-5.5:5.5", "-o",
                    part_ / "turning.vsm"})
                .code,
            0);
  for (const std::string range : {"-5:5", "-.5:.5", "-3"}) {
    const Outcome outcome = vsfind({"find", part_ / "train.png", "--model", part_ / "turning.vsm", "--angle", range});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
  }
}

TEST_F(Program, InspectDescribesListsAndDraws) {
  const Outcome outcome =
      vsfind({"inspect", part_.model(), "--points", part_ / "points.csv", "--picture", part_ / "points.png"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("size         80 x 80 pattern pixels"));
  const auto points = csv_rows(read_file(part_ / "points.csv"));
  EXPECT_THAT(read_file(part_ / "points.csv"), StartsWith("level,x,y,"));
  ASSERT_GT(points.size(), 20U);
  for (const auto& point : points) {
    EXPECT_LE(std::abs(std::stod(point.at("x"))), 41.0);
    EXPECT_LE(std::abs(std::stod(point.at("y"))), 41.0);
  }
  EXPECT_GE(cv::imread(part_ / "points.png").cols, 640);
  EXPECT_THAT(vsfind({"inspect", part_.model(), "--points", "-"}).out, StartsWith("level,x,y,"));
}

}  // namespace
}  // namespace vsfind::test
