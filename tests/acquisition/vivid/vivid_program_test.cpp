/// The commands on the real driver: what they list, refuse and set, and the search of what they recorded.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/acquisition/vivid/results.h"
#include "tests/acquisition/vivid/shown_frame.h"
#include "tests/app/shell.h"

namespace vsfind::test {
namespace {

using testing::HasSubstr;

TEST_F(VividTest, CamerasListsWhatCanBeOpened) {
  ASSERT_EQ(guest_code("cameras"), 0) << guest_text("cameras.err");
  const auto lines = lines_of(guest_text("cameras.out"));
  ASSERT_EQ(lines.size(), 2U) << "the outputs, VBI, radio and touch nodes are no cameras";
  EXPECT_THAT(lines[0], testing::StartsWith("v4l2:/dev/video0  vivid  "));
  EXPECT_THAT(lines[0], HasSubstr("GREY"));
  EXPECT_THAT(lines[0], HasSubstr("320x180 … 3840x2160 (6 sizes)"));
  EXPECT_THAT(lines[0], HasSubstr("timestamps of the end of a frame (monotonic clock)"));
  EXPECT_THAT(lines[1], testing::StartsWith("v4l2:/dev/video20  vivid  "));
  EXPECT_THAT(lines[1], HasSubstr("NM12"));

  ASSERT_EQ(guest_code("cameras_json"), 0);
  const auto json = nlohmann::json::parse(guest_text("cameras_json.out"));
  ASSERT_EQ(json.size(), 2U);
  EXPECT_EQ(json[0]["timestamps"]["of"], "end");
  EXPECT_EQ(json[0]["uri"], "v4l2:/dev/video0");
  EXPECT_EQ(json[0]["model"], "vivid");
  EXPECT_EQ(json[0]["address"], "platform:vivid-000");
  EXPECT_EQ(json[0]["problem"], "");
  int known = 0;
  for (const auto& format : json[0]["formats"]) {
    if (format["name"] == "GREY" || format["name"] == "RGB3") {
      ++known;
      EXPECT_EQ(format["direct"], format["name"] == "GREY");
      EXPECT_EQ(format["sizes"].size(), 6U);
      EXPECT_EQ(format["sizes"][0]["width"], 320);
      EXPECT_EQ(format["sizes"][0]["height"], 180);
      EXPECT_THAT(format["sizes"][0]["rates"].get<std::vector<double>>(), testing::Contains(60.0));
    }
  }
  EXPECT_EQ(known, 2);
}

struct Refusal {
  const char* step;
  int code;
  const char* names;    // what is wrong
  const char* allowed;  // what would be right
};
void PrintTo(const Refusal& refusal, std::ostream* stream) { *stream << refusal.step; }
class VividRefusal : public VividTestWith<Refusal> {};

INSTANTIATE_TEST_SUITE_P(
    , VividRefusal,
    testing::Values(
        Refusal{"input", 2, "'SCART'", "1 or 'S-Video 0'"}, Refusal{"standard", 2, "'PAL-X'", "PAL-M"},
        Refusal{"standard_of_a_webcam", 2, "'PAL'", "no video standards"},
        Refusal{"size", 2, "641x359", "it gives 640x360"}, Refusal{"pixel_format", 2, "'Y99'", "Y10"},
        Refusal{"field_order", 2, "'none'", "interlaced"}, Refusal{"field_order_word", 2, "'diagonal'", "seq_tb"},
        Refusal{"frame_rate", 2, "1000", "60"}, Refusal{"control", 2, "'Colour of the Sky'", "'Brightness'"},
        Refusal{"control_value", 2, "'999'", "0 to 255"}, Refusal{"control_menu", 2, "'Stripes'", "'75% Colorbar'"},
        Refusal{"control_read_only", 2, "Read-Only", "can only be read"}, Refusal{"exposure", 2, "exposure", "by name"},
        Refusal{"gain", 2, "'100000'", "0 to 255"}, Refusal{"device", 4, "v4l2:/dev/video9", "no such device"},
        Refusal{"output_device", 4, "v4l2:/dev/video1", "captures no pictures"},
        Refusal{"no_v4l2", 4, "v4l2:/dev/null", "is not a V4L2 device"},
        Refusal{"a_file", 4, "v4l2:/etc/passwd", "is not a device"}),
    [](const auto& tested) { return std::string(tested.param.step); });

TEST_P(VividRefusal, IsOneLineWithWhatIsAllowed) {
  const Refusal& refusal = GetParam();
  const std::string step = std::string("refused_") + refusal.step;
  EXPECT_EQ(guest_code(step), refusal.code);
  const std::string text = guest_text(step + ".err");
  EXPECT_EQ(lines_of(text).size(), 1U) << text;
  EXPECT_THAT(text, testing::StartsWith("vsfind: v4l2:/"));
  EXPECT_THAT(text, HasSubstr(refusal.names));
  EXPECT_THAT(text, HasSubstr(refusal.allowed));
}

TEST_F(VividTest, TakesSettingsByName) {
  EXPECT_EQ(guest_code("settings"), 0) << guest_text("settings.err");
  const GuestRecording recording = guest_recording("settings");
  EXPECT_EQ(recording.info.width, 640);
  EXPECT_EQ(recording.info.height, 360);
  EXPECT_DOUBLE_EQ(recording.info.frame_rate.value(), 30.0);
  // Half a second, on a machine that may be slow.
  EXPECT_GE(recording.frames.size(), 3U);
  EXPECT_LE(recording.frames.size(), 40U);
  EXPECT_THAT(guest_text("settings.err"), HasSubstr("timestamps of the end of a frame"));
  // The pattern is all black.
  const ImageView& image = recording.frames.at(0).image();
  EXPECT_LE(image.at(image.width / 2, image.height - 10), 16);
}

using Rows = std::vector<std::map<std::string, std::string>>;

/// Compares the rows of a search, whose pixels are those of a recording of the guest's, with where the part was shown.
void expect_found_where_shown(Rows rows, const std::string& recording, std::size_t least) {
  const std::string data = std::string(VSFIND_TEST_DATA) + "/interlaced";
  std::map<std::pair<std::uint32_t, std::string>, std::map<std::string, std::string>> truth;
  for (auto& row : csv_rows(read_file(data + "/truth.csv")))
    truth[{static_cast<std::uint32_t>(std::stoul(row["frame"])), row["field"]}] = row;
  std::map<std::pair<std::string, std::string>, std::uint32_t> shown;  // what a recorded frame or field shows
  const ShownFrames frames(VIVID_RECORDING, 720, 576);
  for (const Frame& frame : guest_recording(recording).frames) {
    const auto number = shown_number(frame.image());
    ASSERT_TRUE(number);
    for (const Field field : {Field::top, Field::bottom}) {
      if (frame.info().field == Field::frame || frame.info().field == field)
        shown[{std::to_string(frame.info().sequence), name(field)}] = *number % frames.recorded();
    }
  }
  EXPECT_EQ(rows.size(), shown.size()) << "a row per field";
  std::size_t compared = 0;
  for (auto& row : rows) {
    const std::uint32_t number = shown.at({row["frame"], row["field"]});
    auto& expected = truth.at({number, row["field"]});
    const std::string where = fmt::format("frame {} ({}), recorded as {}", row["frame"], row["field"], number);
    if (expected["x"].empty()) {
      EXPECT_EQ(row["status"], "not_found") << where;
      continue;
    }
    ASSERT_EQ(row["status"], "found") << where;
    EXPECT_NEAR(std::stod(row["image_x"]) - frames.placement().x, std::stod(expected["x"]), 0.1) << where;
    EXPECT_NEAR(std::stod(row["image_y"]) - frames.placement().y, std::stod(expected["y"]), 0.1) << where;
    EXPECT_NEAR(std::stod(row["angle_deg"]), std::stod(expected["angle_deg"]), 0.1) << where;
    ++compared;
  }
  EXPECT_GE(compared, least);
}

/// The rows of a replay of a recording of the guest's.
Rows replayed(const std::string& recording) {
  const Outcome found = vsfind({"replay", guest_file(recording + ".y4m"), "--model", VIVID_MODEL, "--field", "split",
                                "--pixel-aspect", "1:1", "--csv", "-"});
  EXPECT_EQ(found.code, 0) << found.err;
  return csv_rows(found.out);
}

class VividSearch : public VividTestWith<std::string> {};
INSTANTIATE_TEST_SUITE_P(, VividSearch, testing::Values("loop_pal_interlaced", "loop_pal_alternate"),
                         [](const auto& tested) { return tested.param; });

TEST_P(VividSearch, FindsThePartInEveryFieldWhereItWasShown) {
  ASSERT_EQ(guest_code(GetParam()), 0);
  expect_found_where_shown(replayed(GetParam()), GetParam(), 10);
}

TEST_F(VividTest, LiveFindsThePartAsItComes) {
  ASSERT_EQ(guest_code("live"), 0) << guest_text("live.err");
  Rows rows = csv_rows(guest_text("live.csv"));
  expect_found_where_shown(rows, "live", 4);
  Rows again = replayed("live");
  for (Rows* all : {&rows, &again}) {
    for (auto& row : *all) {
      for (const char* other : {"source", "search_ms", "latency_ms"}) row.erase(other);
    }
  }
  EXPECT_EQ(rows, again) << "a replay of what live recorded gives the same rows";
}

}  // namespace
}  // namespace vsfind::test
