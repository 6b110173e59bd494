#include "app/config.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <random>

#include "acquisition/errors.h"
#include "app/run_options.h"
#include "tests/app/shell.h"

namespace vsfind {
namespace {

using test::TemporaryFolder;
using test::write_file;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

class ConfigTest : public testing::Test {
 protected:
  /// What is said about a configuration with this text, its folder cut away; "" where it is taken.
  std::string complaint(const std::string& text) {
    write_file(folder_ / "c.yaml", text);
    try {
      options_ = RunOptions{};
      apply_config(load_config(folder_ / "c.yaml"), run_settings(options_, ""));
      return {};
    } catch (const UsageError& error) {
      std::string line = error.what();
      EXPECT_THAT(line, StartsWith(folder_.path() + "/c.yaml"));
      EXPECT_THAT(line, Not(HasSubstr("\n")));
      return line.substr(folder_.path().size() + 1);
    }
  }

  TemporaryFolder folder_;
  RunOptions options_;
};

TEST_F(ConfigTest, SetsWhatTheCommandLineWouldSet) {
  EXPECT_EQ(complaint("# a comment\n"
                      "model: [a.vsm, /abs/b.vsm]\n"
                      "min_score: 0.75\n"
                      "max_instances: 0\n"
                      "angle: -45:45\n"
                      "scale_x: [0.9, 1.1]\n"
                      "region: [1, 2, 30, 40]\n"
                      "field: split\n"
                      "pixel_aspect: pal\n"
                      "csv: rows.csv\n"
                      "jsonl: '-'\n"
                      "threads: 2\n"),
            "");
  EXPECT_THAT(options_.models, ElementsAre(folder_ / "a.vsm", "/abs/b.vsm"));
  EXPECT_EQ(options_.search.min_score, 0.75);
  EXPECT_EQ(options_.search.max_instances, 0);
  EXPECT_EQ(options_.search.angle_deg->min, -45.0);
  EXPECT_EQ(options_.search.angle_deg->max, 45.0);
  EXPECT_EQ(options_.search.scale_x->max, 1.1);
  EXPECT_FALSE(options_.search.scale_y);
  EXPECT_EQ(options_.search.region->height, 40);
  EXPECT_EQ(options_.field, FieldMode::split);
  EXPECT_DOUBLE_EQ(options_.mapping.pixel_aspect->value, 59.0 / 54.0);
  EXPECT_EQ(options_.csv, folder_ / "rows.csv");
  EXPECT_EQ(options_.jsonl, "-");
  EXPECT_EQ(options_.search.threads, 2);
}

TEST_F(ConfigTest, AnEmptyFileSetsNothing) {
  EXPECT_EQ(complaint(""), "");
  EXPECT_EQ(complaint("# only words\n"), "");
}

TEST_F(ConfigTest, UnknownKeysAreRefusedWithLineAndNearestKey) {
  EXPECT_THAT(complaint("angle: 1\n\nmin_scoer: 0.5\n"),
              AllOf(StartsWith("c.yaml:3: key min_scoer is not known (did you mean min_score?)"),
                    HasSubstr("allowed: model, min_score")));
  EXPECT_THAT(complaint("colour: red\n"), AllOf(HasSubstr("key colour is not known"), Not(HasSubstr("did you mean"))));
  // Options' own spelling is not a key's.
  EXPECT_THAT(complaint("min-score: 0.5\n"), HasSubstr("did you mean min_score?"));
  EXPECT_THAT(complaint("<<: {angle: 1}\n"), HasSubstr("key <<"));
}

TEST_F(ConfigTest, BadValuesNameLineKeyAndAllowedValues) {
  EXPECT_THAT(complaint("field: splt\n"),
              StartsWith("c.yaml:1: key field: 'splt' is not known (did you mean split?) (allowed: frame, top"));
  EXPECT_THAT(complaint("\nangle: 5:-5\n"), AllOf(StartsWith("c.yaml:2: key angle: '5:-5'"), HasSubstr("MIN:MAX")));
  EXPECT_THAT(complaint("min_score: 7\n"), HasSubstr("a number from 0 to 1"));
  EXPECT_THAT(complaint("min_score:\n"), HasSubstr("key min_score: needs a value"));
  EXPECT_THAT(complaint("min_score: [0.5, 0.6]\n"), HasSubstr("is a list"));
  EXPECT_THAT(complaint("model: []\n"), HasSubstr("the list is empty"));
  EXPECT_THAT(complaint("model: [a, [b]]\n"), HasSubstr("more than plain values"));
  EXPECT_THAT(complaint("angle: {min: 1}\n"), HasSubstr("holds keys of its own"));
  EXPECT_THAT(complaint("angle: [1, 2, 3]\n"), HasSubstr("'1:2:3' is not a range"));
}

TEST_F(ConfigTest, DuplicatesAndContradictionsAreRefused) {
  EXPECT_THAT(complaint("angle: 1\nfield: top\nangle: 2\n"),
              StartsWith("c.yaml:3: key angle: stands in line 1 already"));
  EXPECT_THAT(complaint("scale: 1\nscale_x: 1\n"), HasSubstr("cannot be given together with scale-x"));
  EXPECT_THAT(complaint("calibration: a\npixel_aspect: pal\n"), HasSubstr("cannot be given together"));
}

TEST_F(ConfigTest, WhatIsNoMappingIsRefused) {
  EXPECT_THAT(complaint("- a\n- b\n"), HasSubstr("allowed: KEY: VALUE"));
  EXPECT_THAT(complaint("just words\n"), HasSubstr("allowed: KEY: VALUE"));
  EXPECT_THAT(complaint("angle: [1\nfield: top\n"), HasSubstr("is not YAML"));
  EXPECT_THAT(complaint("a: 1\n---\nb: 2\n"), HasSubstr("more than one YAML document"));
  EXPECT_THAT(complaint("? [a, b]\n: 1\n"), HasSubstr("a key is not a plain word"));
  EXPECT_THAT(complaint("angle: *nowhere\n"), HasSubstr("is not YAML"));
  EXPECT_THAT(complaint(std::string("angle: 1\n\0", 10)), HasSubstr("zero byte"));
}

TEST_F(ConfigTest, HostileFilesEndInOneLine) {
  EXPECT_THAT(complaint(std::string(2'000'000, 'a')), HasSubstr("allowed: 1 MB"));
  EXPECT_THAT(complaint(std::string(900'000, '[')), HasSubstr("nested too deeply"));
  std::string dashes;
  for (int i = 0; i < 300'000; ++i) dashes += "- ";
  EXPECT_THAT(complaint(dashes), HasSubstr("nested too deeply"));
  std::string steps;
  for (std::size_t i = 0; i < 1000; ++i) steps += std::string(i, ' ') + "a:\n";
  EXPECT_THAT(complaint(steps), HasSubstr("nested too deeply"));
  // Each level ten times the one before: a parser that copied would need 10^9 nodes.
  std::string bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 9; ++i) {
    const std::string before = "*a" + std::to_string(i - 1);
    bomb += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" + before;
    for (int j = 1; j < 10; ++j) bomb += ", " + before;
    bomb += "]\n";
  }
  EXPECT_NE(complaint(bomb), "");
  EXPECT_NE(complaint("a: &a [*a]\n"), "");
  std::string garbage;
  for (int i = 0; i < 4096; ++i) garbage += static_cast<char>((i * 7919) % 255 + 1);
  EXPECT_NE(complaint(garbage), "");
}

TEST_F(ConfigTest, RandomDamageNeverDoesMoreThanThrow) {
  const std::string whole = test::read_file(VSFIND_SOURCE_DIR "/configs/replay.yaml");
  ASSERT_GT(whole.size(), 500U);
  std::mt19937 random(11);
  const std::string signs = "[]{}:-?&*!|>'\"%@`,#\n\t ~a1.";
  int refused = 0;
  for (int round = 0; round < 1000; ++round) {
    std::string text = whole;
    for (int i = 0; i < 4; ++i) text[random() % text.size()] = signs[random() % signs.size()];
    if (round % 3 == 0) text.resize(random() % text.size());
    write_file(folder_ / "c.yaml", text);
    try {
      options_ = RunOptions{};
      apply_config(load_config(folder_ / "c.yaml"), run_settings(options_, ""));
    } catch (const UsageError& error) {
      ++refused;
      EXPECT_THAT(error.what(), Not(HasSubstr("\n")));
    }
  }
  EXPECT_GT(refused, 100);
}

TEST_F(ConfigTest, FilesThatCannotBeReadAreInputErrors) {
  EXPECT_THROW((void)load_config(folder_ / "none.yaml"), IoError);
  EXPECT_THROW((void)load_config(folder_.path()), IoError);
}

}  // namespace
}  // namespace vsfind
