#include "app/row_file.h"

#include <gmock/gmock.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>

#include "acquisition/errors.h"
#include "tests/app/shell.h"

namespace vsfind {
namespace {

using test::lines_of;
using test::read_file;
using testing::ElementsAre;
using testing::SizeIs;

class RowFileTest : public testing::Test {
 protected:
  void SetUp() override {
    ::setenv("TZ", "UTC", 1);
    ::tzset();
    options_.now = [this] { return now_; };
  }
  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
      all.push_back(entry.path().filename());
    std::sort(all.begin(), all.end());
    return all;
  }

  test::TemporaryFolder folder_;
  std::time_t now_ = 1'700'000'000;  // 2023-11-14 22:13:20 UTC
  RowFileOptions options_;
};

TEST_F(RowFileTest, RotatesBeforeItGrowsBeyondItsSize) {
  options_.max_bytes = 30;
  RowFile file(folder_ / "rows.csv", "header", options_);
  for (int i = 0; i < 7; ++i) {
    file.write_line("line " + std::to_string(i) + "...");
    now_ += 10;
  }
  EXPECT_THAT(names(), ElementsAre("rows-20231114-221320.csv", "rows-20231114-221340.csv", "rows-20231114-221400.csv",
                                   "rows.csv"));
  EXPECT_EQ(read_file(folder_ / "rows-20231114-221320.csv"), "header\nline 0...\nline 1...\n");
  EXPECT_EQ(read_file(folder_ / "rows.csv"), "header\nline 6...\n");
}

TEST_F(RowFileTest, RotatesAtMidnight) {
  options_.daily = true;
  RowFile file(folder_ / "rows.jsonl", "", options_);
  file.write_line("today");
  now_ += 6399;  // a second before midnight
  file.write_line("still today");
  now_ += 1;
  file.write_line("tomorrow");
  EXPECT_EQ(read_file(folder_ / "rows-20231114-221320.jsonl"), "today\nstill today\n");
  EXPECT_EQ(read_file(folder_ / "rows.jsonl"), "tomorrow\n");
}

TEST_F(RowFileTest, NamesThatAreTakenAreNotTakenAgain) {
  options_.max_bytes = 1;
  RowFile file(folder_ / "rows.csv", "", options_);
  for (int i = 0; i < 4; ++i) file.write_line(std::to_string(i));
  EXPECT_THAT(names(), ElementsAre("rows-20231114-221320-2.csv", "rows-20231114-221320-3.csv",
                                   "rows-20231114-221320.csv", "rows.csv"));
}

TEST_F(RowFileTest, KeepsTheNewestAndRemovesNothingElse) {
  const std::vector<std::string> others{"rows-20231114-22132.csv",
                                        "rows-20231114-221320.csv.gz",
                                        "rows-20231114-221320-.csv",
                                        "rows-20231114-221320-x.csv",
                                        "rows-2.csv",
                                        "rows-old.csv",
                                        "other-20200101-000000.csv",
                                        "rows-20231114x221320.csv",
                                        "rows-20200101-000000.jsonl"};
  for (const auto& name : others) test::write_file(folder_ / name, "not rotated away from rows.csv");
  std::filesystem::create_directory(folder_ / "rows-20200101-000000.csv");
  for (const char* old : {"rows-20220101-000000.csv", "rows-20220101-000000-2.csv", "rows-20220101-000000-10.csv"})
    test::write_file(folder_ / old, "of an earlier run");
  options_.max_bytes = 1;
  options_.keep = 3;
  const auto left = [&] {
    std::vector<std::string> rotated;
    for (const auto& name : names()) {
      if (std::find(others.begin(), others.end(), name) == others.end()) rotated.push_back(name);
    }
    return rotated;
  };
  RowFile file(folder_ / "rows.csv", "", options_);
  EXPECT_THAT(left(), SizeIs(5)) << "three rotated ones, a folder, and the file";
  file.write_line("0");
  file.write_line("1");
  EXPECT_THAT(left(), ElementsAre("rows-20200101-000000.csv", "rows-20220101-000000-10.csv",
                                  "rows-20220101-000000-2.csv", "rows-20231114-221320.csv", "rows.csv"));
  file.write_line("2");
  file.write_line("3");
  EXPECT_THAT(left(), ElementsAre("rows-20200101-000000.csv", "rows-20231114-221320-2.csv",
                                  "rows-20231114-221320-3.csv", "rows-20231114-221320.csv", "rows.csv"));
  EXPECT_EQ(read_file(folder_ / "rows.csv"), "3\n");
  EXPECT_THAT(names(), SizeIs(others.size() + 5));
}

TEST_F(RowFileTest, WhatAnEarlierRunWroteIsKeptWhereFilesRotate) {
  test::write_file(folder_ / "rows.csv", "old\n");
  options_.daily = true;
  RowFile(folder_ / "rows.csv", "header", options_).write_line("new");
  EXPECT_THAT(names(), SizeIs(2));
  EXPECT_EQ(read_file(folder_ / "rows.csv"), "header\nnew\n");
  options_.daily = false;
  RowFile(folder_ / "rows.csv", "header", options_).write_line("newer");
  EXPECT_EQ(read_file(folder_ / "rows.csv"), "header\nnewer\n");
  EXPECT_THAT(names(), SizeIs(2));
}

TEST_F(RowFileTest, AFullDiskCostsTheLinesOfItsTimeOnly) {
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  RowFile strict(folder_ / "strict", "", options_);
  options_.keep_going = true;
  RowFile file(folder_ / "rows.csv", "header", options_);
  file.write_line("one");
  rlimit full = before;
  full.rlim_cur = 14;  // room for a part of the next line
  ::setrlimit(RLIMIT_FSIZE, &full);
  for (int i = 0; i < 3; ++i) file.write_line("does not fit");
  EXPECT_THROW(strict.write_line("does not fit either"), IoError);
  ::setrlimit(RLIMIT_FSIZE, &before);
  file.write_line("two");
  EXPECT_EQ(read_file(folder_ / "rows.csv"), "header\none\ntwo\n");
  EXPECT_EQ(file.lost(), 3U);
}

}  // namespace
}  // namespace vsfind
