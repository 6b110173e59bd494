#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "tests/app/scene.h"

namespace vsfind::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Matcher;
using testing::StartsWith;

class BadInput : public testing::Test {
 protected:
  static void SetUpTestSuite() { part_ = new TrainedPart; }
  static void TearDownTestSuite() {
    delete part_;
    part_ = nullptr;
  }
  static const TrainedPart& part() { return *part_; }

  /// One line, the code, and what must stand in it.
  static void expect_refused(const std::vector<std::string>& arguments, int code, const Matcher<std::string>& line) {
    std::string shown;
    for (const auto& argument : arguments) shown += argument.substr(0, 60) + " ";
    SCOPED_TRACE(shown);
    const Outcome outcome = vsfind(arguments);
    EXPECT_EQ(outcome.code, code);
    EXPECT_EQ(lines_of(outcome.err).size(), 1U) << outcome.err;
    EXPECT_THAT(outcome.err, AllOf(StartsWith("vsfind: "), line));
    EXPECT_EQ(outcome.out, "");
  }
  static std::vector<std::string> find(std::vector<std::string> more) {
    std::vector<std::string> arguments{"find", part() / "train.png", "--model", part().model()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  static std::vector<std::string> train(std::vector<std::string> more) {
    std::vector<std::string> arguments{"train", part() / "train.png", "-o", part() / "new.vsm"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

 private:
  static TrainedPart* part_;
};
TrainedPart* BadInput::part_ = nullptr;

TEST_F(BadInput, CommandsAndOptionsThatDoNotExist) {
  expect_refused({}, 2, HasSubstr("a command is needed (allowed: train, find, replay, "));
  expect_refused({"fnid"}, 2, HasSubstr("did you mean find?"));
  expect_refused({""}, 2, HasSubstr("unknown command ''"));
  expect_refused({"--colour"}, 2, HasSubstr("unknown option --colour; see vsfind --help"));
  expect_refused(find({"--min-scoer", "0.5"}), 2, HasSubstr("unknown option --min-scoer (did you mean --min-score?)"));
  expect_refused({"find", "--modle", "x"}, 2, HasSubstr("did you mean --model?"));
  expect_refused(find({"-z"}), 2, HasSubstr("unknown option -z"));
  expect_refused({"inspect", part().model(), "more.vsm"}, 2, HasSubstr("more.vsm"));
}

TEST_F(BadInput, NeededOptionsThatAreMissing) {
  expect_refused({"train"}, 2, HasSubstr("an IMAGE is needed"));
  expect_refused({"train", "a.png", "-o", "x"}, 2, HasSubstr("--roi is needed"));
  expect_refused({"train", "a.png", "--roi", "1,2,3,4"}, 2, HasSubstr("--output is needed"));
  expect_refused({"find"}, 2, HasSubstr("an IMAGE is needed"));
  expect_refused({"find", "a.png"}, 2, HasSubstr("--model is needed"));
  expect_refused({"replay"}, 2, HasSubstr("a SEQUENCE is needed"));
  expect_refused({"inspect"}, 2, HasSubstr("a MODEL is needed"));
  expect_refused(find({"--angle"}), 2, HasSubstr("--angle"));
}

TEST_F(BadInput, ValuesThatCannotBe) {
  expect_refused(find({"--angle", "45:-45"}), 2, AllOf(HasSubstr("--angle '45:-45'"), HasSubstr("MIN:MAX")));
  expect_refused(find({"--angle", "abc"}), 2, HasSubstr("--angle 'abc' is not a range"));
  expect_refused(find({"--angle", "-45:45"}), 2, HasSubstr("angle"));  // wider than trained
  expect_refused(find({"--scale", "3"}), 2, HasSubstr("--scale '3' is out of range"));
  expect_refused(find({"--scale", "1", "--scale-x", "1"}), 2, HasSubstr("cannot be given together"));
  expect_refused(find({"--min-score", "1.5"}), 2, HasSubstr("a number from 0 to 1"));
  expect_refused(find({"--min-score", "0.5", "--min-score", "0.6"}), 2, HasSubstr("more than once"));
  expect_refused(find({"--max-instances", "-1"}), 2, HasSubstr("--max-instances '-1'"));
  expect_refused(find({"--threads", "0"}), 2, HasSubstr("from 1 to 64"));
  expect_refused(find({"--field", "both"}), 2, HasSubstr("allowed: frame, top, bottom, split"));
  expect_refused(find({"--pixel-aspect", "secam"}), 2, HasSubstr("--pixel-aspect"));
  expect_refused(find({"--region", "1,2,3"}), 2, HasSubstr("X,Y,W,H"));
  expect_refused(find({"--region", "320,0,10,10"}), 2, AllOf(HasSubstr("lies outside"), HasSubstr("320x240")));
  expect_refused(find({"--csv", "-", "--jsonl", "-"}), 2, HasSubstr("cannot both go to stdout"));
  expect_refused(find({"--csv", ""}), 2, HasSubstr("--csv"));
}

TEST_F(BadInput, TrainingThatCannotBe) {
  expect_refused(train({"--roi", "300,80,80,80"}), 2,
                 AllOf(HasSubstr("--roi 300,80,80,80 reaches outside"), HasSubstr("320x240")));
  expect_refused(train({"--roi", "1,2,3"}), 2, HasSubstr("X,Y,W,H"));
  expect_refused(train({"--roi", "0,0,0,0"}), 2, HasSubstr("out of range"));
  expect_refused(train({"--roi", roi_at(100, 80), "--accuracy", "101"}), 2, HasSubstr("from 1 to 100"));
  expect_refused(train({"--roi", roi_at(100, 80), "--angle", "-360:360"}), 2, HasSubstr("angle"));
  expect_refused(train({"--roi", roi_at(100, 80), "--scale", "0.1:1"}), 2, HasSubstr("from 0.5 to 2"));
  expect_refused(train({"--roi", roi_at(100, 80), "--origin", "1"}), 2, HasSubstr("X,Y"));
  expect_refused(train({"--roi", roi_at(100, 80), "--polarity", "both"}), 2, HasSubstr("same, reversed, any"));
  expect_refused(train({"--roi", roi_at(100, 80), "--field", "split"}), 2, HasSubstr("allowed: frame, top, bottom"));
  expect_refused(train({"--roi", roi_at(100, 80), "--edge-threshold", "soft"}), 2, HasSubstr("--edge-threshold"));
  expect_refused(train({"--roi", roi_at(100, 80), "--edge-threshold", "1e-12"}), 2, HasSubstr("0.01"));
  expect_refused(train({"--roi", roi_at(100, 80), "--name", ""}), 2, HasSubstr("--name"));
  cv::imwrite(part() / "flat.png", cv::Mat(240, 320, CV_8UC1, cv::Scalar(90)));
  expect_refused({"train", part() / "flat.png", "--roi", roi_at(100, 80), "-o", part() / "f.vsm"}, 2, HasSubstr(""));
  EXPECT_FALSE(std::filesystem::exists(part() / "f.vsm"));
  cv::imwrite(part() / "mask.png", cv::Mat(50, 60, CV_8UC1, cv::Scalar(255)));
  expect_refused(train({"--roi", roi_at(100, 80), "--mask", part() / "mask.png"}), 2,
                 AllOf(HasSubstr("60x50"), HasSubstr("320x240"), HasSubstr("80x80")));
  expect_refused(train({"--roi", roi_at(100, 80), "--mask", part() / "none.png"}), 3, HasSubstr("none.png"));
  expect_refused(train({"--roi", roi_at(100, 80), "--against", part() / "none.png"}), 3, HasSubstr("none.png"));
  expect_refused({"train", part() / "train.png", "--roi", roi_at(100, 80), "-o", part() / "no/folder.vsm"}, 3,
                 HasSubstr("no/folder.vsm"));
}

TEST_F(BadInput, FilesThatAreMissingOrWrong) {
  const std::string& model = part().model();
  expect_refused({"find", part() / "none.png", "--model", model}, 3, HasSubstr("none.png"));
  expect_refused({"find", part().path(), "--model", model}, 3, HasSubstr(part().path()));
  expect_refused({"find", model, "--model", model}, 3, HasSubstr("part.vsm"));
  expect_refused({"replay", part() / "none.y4m", "--model", model}, 3, HasSubstr("none.y4m"));
  expect_refused({"replay", model, "--model", model}, 3, HasSubstr("part.vsm"));
  expect_refused({"find", part() / "train.png", "--model", part() / "none.vsm"}, 3, HasSubstr("none.vsm"));
  expect_refused({"find", part() / "train.png", "--model", part() / "train.png"}, 2, HasSubstr("train.png"));
  expect_refused({"inspect", part().path()}, 3, HasSubstr(part().path()));
  expect_refused(find({"--calibration", part() / "none.yaml"}), 3, HasSubstr("none.yaml"));
  expect_refused(find({"--calibration", part() / "train.png"}), 2, HasSubstr("train.png"));
  std::filesystem::create_directory(part() / "empty");
  expect_refused({"replay", part() / "empty", "--model", model}, 3, HasSubstr("empty"));
}

TEST_F(BadInput, FileNamesWithLineBreaksStillGiveOneLine) {
  expect_refused({"find", "a\nb\x1b[31m.png", "--model", part().model()}, 3, HasSubstr("a b [31m.png"));
}

TEST_F(BadInput, DamagedModels) {
  const std::string text = read_file(part().model());
  const auto refused = [&](const std::string& name, const std::string& bytes) {
    write_file(part() / name, bytes);
    expect_refused({"inspect", part() / name}, 2, HasSubstr(name));
    expect_refused({"find", part() / "train.png", "--model", part() / name}, 2, HasSubstr(name));
  };
  refused("empty.vsm", "");
  refused("garbage.vsm", std::string(5000, '\xfe'));
  refused("braces.vsm", std::string(1'000'000, '['));
  refused("number.vsm", "1e999999");
  refused("truncated.vsm", text.substr(0, text.size() / 2));
  refused("last-byte.vsm", text.substr(0, text.size() - text.size() / 100 - 2));
  std::string flipped = text;
  flipped[flipped.size() / 2] = flipped[flipped.size() / 2] == '1' ? '2' : '1';
  refused("flipped.vsm", flipped);
}

TEST_F(BadInput, OutputsThatCannotBeWritten) {
  expect_refused(find({"--csv", part() / "no/rows.csv"}), 3, HasSubstr("no/rows.csv"));
  expect_refused(find({"--csv", "/dev/full"}), 3, AllOf(HasSubstr("/dev/full"), HasSubstr("No space left")));
  expect_refused(find({"--overlay", part() / "train.png"}), 3, HasSubstr("train.png"));
  expect_refused(find({"--overlay", "/proc/none"}), 3, HasSubstr("/proc/none"));
  expect_refused({"inspect", part().model(), "--points", "/dev/full"}, 3, HasSubstr("/dev/full"));
  expect_refused({"inspect", part().model(), "--picture", part() / "no/p.png"}, 3, HasSubstr("no/p.png"));
  const Outcome full = vsfind(find({}), "/dev/full");
  EXPECT_EQ(full.code, 3);
  EXPECT_THAT(full.err, AllOf(HasSubstr("stdout"), HasSubstr("No space left")));
  EXPECT_EQ(vsfind({"--help"}, "/dev/full").code, 3);
}

TEST_F(BadInput, Configurations) {
  const auto refused = [&](const std::string& text, int code, const Matcher<std::string>& line) {
    write_file(part() / "c.yaml", text);
    expect_refused({"replay", "--config", part() / "c.yaml"}, code, line);
  };
  refused("source: a.y4m\nmodle: part.vsm\n", 2, AllOf(HasSubstr("c.yaml:2: key modle"), HasSubstr("mean model?")));
  refused("source: a.y4m\nmodel: part.vsm\nangle: wide\n", 2, HasSubstr("c.yaml:3: key angle: 'wide'"));
  refused("source: [\n", 2, HasSubstr("is not YAML"));
  refused("model: part.vsm\n", 2, HasSubstr("a SEQUENCE is needed"));
  refused("source: a.y4m\nmodel: part.vsm\n", 3, HasSubstr("a.y4m"));
  expect_refused({"replay", "--config", part() / "none.yaml"}, 3, HasSubstr("none.yaml"));
}

TEST_F(BadInput, OneBadImageCostsOnlyItsOwnRow) {
  const Outcome outcome =
      vsfind({"find", part() / "train.png", part() / "none.png", part() / "train.png", "--model", part().model()});
  EXPECT_EQ(outcome.code, 3);
  const auto rows = csv_rows(outcome.out);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[1].at("frame"), "2");
  EXPECT_THAT(lines_of(outcome.err)[0], HasSubstr("none.png"));
}

TEST_F(BadInput, EarlierRowsAreKeptWhereTheRunCannotBegin) {
  write_file(part() / "rows.csv", "precious\n");
  EXPECT_EQ(vsfind(find({"--csv", part() / "rows.csv", "--angle", "-90:90"})).code, 2);
  EXPECT_EQ(vsfind({"find", part() / "none.png", "--model", part().model(), "--csv", part() / "rows.csv"}).code, 3);
  EXPECT_EQ(read_file(part() / "rows.csv"), "precious\n");
}

}  // namespace
}  // namespace vsfind::test
