#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "acquisition/errors.h"
#include "app/row_writer.h"
#include "tests/app/shell.h"

namespace vsfind {
namespace {

using test::lines_of;
using test::read_file;
using test::TemporaryFolder;

constexpr const char* header =
    "source,frame,timestamp_ns,field,model,status,instance,score,x,y,angle_deg,scale_x,scale_y,unit,image_x,image_y,"
    "sigma_x,sigma_y,sigma_angle_deg,visible,polarity,search_ms,latency_ms,timed_out";

ResultRow found_row() {
  ResultRow row;
  row.source = "a.y4m";
  row.frame = 18446744073709551615ULL;
  row.timestamp_ns = -5;
  row.field = Field::bottom;
  row.model = "part";
  row.status = RowStatus::found;
  row.instance = 2;
  row.match.score = 0.987654;
  row.match.pose = {100.00012, -0.0000001, -12.3456789, 1.0000001, 0.5};
  row.match.frame_position = {99.5, 40.25};
  row.match.sigma_x = 0.00012;
  row.match.sigma_y = 0.5;
  row.match.sigma_angle_deg = 0.001;
  row.match.visible = 0.75;
  row.match.polarity = Polarity::reversed;
  row.unit = "mm";
  row.search_ms = 1.23456;
  row.latency_ms = 2.0;
  row.timed_out = true;
  return row;
}

TEST(CsvWriter, WritesHeaderAndRowsToTheLetter) {
  const TemporaryFolder folder;
  {
    CsvWriter writer(folder / "r.csv");
    EXPECT_EQ(read_file(folder / "r.csv"), std::string(header) + "\n");
    writer.write(found_row());
  }
  const auto lines = lines_of(read_file(folder / "r.csv"));
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines[1],
            "a.y4m,18446744073709551615,-5,bottom,part,found,2,0.98765,100.000120,0.000000,-12.345679,1.0000001,"
            "0.5000000,mm,99.50000,40.25000,0.000120,0.500000,0.001000,0.7500,reversed,1.235,2.000,1");
}

TEST(CsvWriter, LeavesThePoseEmptyWhereNothingIsFound) {
  const TemporaryFolder folder;
  ResultRow row = found_row();
  row.status = RowStatus::not_found;
  row.timed_out = false;
  ResultRow bad = found_row();
  bad.status = RowStatus::bad_frame;
  bad.search_ms.reset();
  bad.timed_out = false;
  {
    CsvWriter writer(folder / "r.csv");
    writer.write(row);
    writer.write(bad);
  }
  const auto lines = lines_of(read_file(folder / "r.csv"));
  EXPECT_EQ(lines[1], "a.y4m,18446744073709551615,-5,bottom,part,not_found,,,,,,,,,,,,,,,,1.235,2.000,0");
  EXPECT_EQ(lines[2], "a.y4m,18446744073709551615,-5,bottom,part,bad_frame,,,,,,,,,,,,,,,,,2.000,0");
}

TEST(CsvWriter, QuotesTextsAndKeepsToUtf8) {
  const TemporaryFolder folder;
  ResultRow row;
  row.source = "a,\"b\"\n.png";
  row.model =
      "\xff"
      "c";
  {
    CsvWriter writer(folder / "r.csv");
    writer.write(row);
  }
  const std::string text = read_file(folder / "r.csv").substr(std::string(header).size() + 1);
  EXPECT_THAT(text, testing::StartsWith("\"a,\"\"b\"\"\n.png\",0,0,frame,\xEF\xBF\xBD"
                                        "c,not_found,"));
}

TEST(CsvWriter, NumbersThatAreNoneStayEmpty) {
  const TemporaryFolder folder;
  ResultRow row = found_row();
  row.match.pose.x = std::nan("");
  row.match.sigma_y = std::numeric_limits<double>::infinity();
  {
    CsvWriter csv(folder / "r.csv");
    csv.write(row);
    JsonlWriter jsonl(folder / "r.jsonl");
    jsonl.write(row);
  }
  EXPECT_THAT(read_file(folder / "r.csv"), testing::HasSubstr(",0.98765,,0.000000,"));
  EXPECT_TRUE(nlohmann::json::parse(read_file(folder / "r.jsonl"))["x"].is_null());
}

TEST(JsonlWriter, HasTheColumnsOfTheCsvInTheirOrder) {
  const TemporaryFolder folder;
  ResultRow row = found_row();
  row.source = "bad\xff.png";
  ResultRow none = found_row();
  none.status = RowStatus::not_found;
  none.timed_out = false;
  {
    JsonlWriter writer(folder / "r.jsonl");
    writer.write(row);
    writer.write(none);
  }
  const auto lines = lines_of(read_file(folder / "r.jsonl"));
  ASSERT_EQ(lines.size(), 2U);
  const auto object = nlohmann::ordered_json::parse(lines[0]);
  std::string keys;
  for (const auto& [key, value] : object.items()) keys += (keys.empty() ? "" : ",") + key;
  EXPECT_EQ(keys, header);
  EXPECT_EQ(object["source"], "bad\xEF\xBF\xBD.png");
  EXPECT_EQ(object["frame"], 18446744073709551615ULL);
  EXPECT_EQ(object["timestamp_ns"], -5);
  EXPECT_EQ(object["x"], 100.00012);
  EXPECT_EQ(object["angle_deg"], -12.345679);
  EXPECT_EQ(object["instance"], 2);
  EXPECT_EQ(object["polarity"], "reversed");
  EXPECT_EQ(object["timed_out"], true);
  const auto missing = nlohmann::ordered_json::parse(lines[1]);
  EXPECT_EQ(missing["status"], "not_found");
  for (const char* key : {"instance", "score", "x", "unit", "polarity", "visible"}) {
    EXPECT_TRUE(missing[key].is_null()) << key;
  }
  EXPECT_EQ(missing["search_ms"], 1.235);
  EXPECT_EQ(missing["timed_out"], false);
}

TEST(OutputFile, FailuresNameFileAndReason) {
  const TemporaryFolder folder;
  const auto complaint = [](const auto& act) -> std::string {
    try {
      act();
    } catch (const IoError& error) {
      return error.what();
    }
    return {};
  };
  EXPECT_THAT(complaint([&] { OutputFile file(folder / "none/r.csv"); }),
              testing::AllOf(testing::HasSubstr("none/r.csv"), testing::HasSubstr("No such file or directory")));
  EXPECT_THAT(complaint([] { OutputFile("/dev/full").write_line("x"); }),
              testing::AllOf(testing::HasSubstr("/dev/full"), testing::HasSubstr("No space left")));
  EXPECT_THAT(complaint([&] { OutputFile file(folder.path()); }), testing::HasSubstr("Is a directory"));
}

}  // namespace
}  // namespace vsfind
