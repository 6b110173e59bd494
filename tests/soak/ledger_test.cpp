/// The soak's books find what they are kept for.
#include "tests/soak/ledger.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace vsfind::test {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

/// Three pictures: the part at x 10, at x 20, and none.
std::string line_of(std::uint64_t frame, int picture) {
  if (picture == 2) {
    return fmt::format(
        R"({{"frame":{},"status":"not_found","score":null,"x":null,"y":null,"angle_deg":null,"scale_x":null,)"
        R"("scale_y":null,"image_x":null,"image_y":null,"visible":null,"timed_out":false}})",
        frame);
  }
  return fmt::format(
      R"({{"frame":{},"status":"found","score":0.9,"x":{}.5,"y":1,"angle_deg":0,"scale_x":1,"scale_y":1,"image_x":1,)"
      R"("image_y":1,"visible":1,"timed_out":false}})",
      frame, 10 * (picture + 1));
}
std::string csv_of(std::uint64_t frame, int picture) {
  return picture == 2 ? fmt::format("{},not_found,,,,,,,,,,0\n", frame)
                      : fmt::format("{},found,0.90000,{}.500000,1,0,1,1,1,1,1,0\n", frame, 10 * (picture + 1));
}
const std::string header = "frame,status,score,x,y,angle_deg,scale_x,scale_y,image_x,image_y,visible,timed_out\n";

Ledger ledger_of(const std::vector<std::pair<std::uint64_t, int>>& rows) {
  std::vector<SoakRow> served;
  for (const int picture : {0, 1, 2}) served.push_back(row_of_json(line_of(0, picture)).value());
  Ledger ledger(served);
  for (const auto& [frame, picture] : rows) ledger.add(line_of(frame, picture));
  return ledger;
}

std::string log_of(const std::string& more, int frames = 4) {
  return fmt::format("vsfind: {} frames: 3 found, 1 not found, 0 bad{}\n", frames, more);
}

TEST(SoakLedger, AllIsWellWhereEveryGapIsTold) {
  Ledger ledger = ledger_of({{0, 1}, {1, 2}, {4, 2}, {5, 0}});
  ledger.compare_csv(header + csv_of(0, 1) + csv_of(4, 2) + csv_of(5, 0));
  ledger.settle("vsfind: 1 rows, pictures or recorded frames could not be written\n" +
                    log_of(", 1 dropped, 1 lost before they came; search time"),
                3);
  EXPECT_THAT(ledger.faults(), IsEmpty());
}

TEST(SoakLedger, FindsEveryKindOfFault) {
  const auto faults = [](Ledger ledger, const std::string& csv, const std::string& log, int code) {
    ledger.compare_csv(header + csv);
    ledger.settle(log, code);
    return ledger.faults();
  };
  const std::vector<std::pair<std::uint64_t, int>> good{{0, 0}, {1, 1}, {2, 2}, {3, 0}};
  const std::string csv = csv_of(0, 0) + csv_of(1, 1) + csv_of(2, 2) + csv_of(3, 0);
  EXPECT_THAT(faults(ledger_of(good), csv, log_of(""), 0), IsEmpty());
  EXPECT_THAT(faults(ledger_of(good), csv, log_of(""), 4), Contains(HasSubstr("exit code 4 instead of 0")));
  EXPECT_THAT(faults(ledger_of(good), csv, "", 0), Contains(HasSubstr("no closing summary")));
  EXPECT_THAT(faults(ledger_of(good), csv, log_of("", 5), 0), Contains(HasSubstr("5 frames are told, 4 rows came")));
  EXPECT_THAT(faults(ledger_of(good), csv, log_of("") + "ERROR: LeakSanitizer", 0), Contains(HasSubstr("LeakSan")));
  EXPECT_THAT(faults(ledger_of(good), csv_of(0, 0), log_of(""), 0), Contains(HasSubstr("3 rows and 0 recorded")));
  EXPECT_THAT(faults(ledger_of(good), csv_of(0, 1), log_of(""), 0),
              Contains(HasSubstr("differs from that of the pipe")));
  EXPECT_THAT(faults(ledger_of(good), csv + "4,fou", log_of(""), 0),
              testing::AllOf(Contains(HasSubstr("end within a line")), Contains(HasSubstr("torn row on the disk"))));
  EXPECT_THAT(faults(ledger_of({{0, 0}, {1, 1}, {2, 2}, {6, 0}}), "", log_of(""), 0),
              Contains(HasSubstr("3 frames are missing, 0 lost and 0 dropped")));
  EXPECT_THAT(faults(ledger_of(good), csv, log_of(", 2 dropped"), 0), Contains(HasSubstr("0 frames are missing")));
  EXPECT_THAT(faults(ledger_of({{0, 0}, {1, 1}, {1, 1}, {2, 2}}), "", log_of(""), 0),
              Contains(HasSubstr("came twice")));
  EXPECT_THAT(faults(ledger_of({{0, 0}, {1, 2}, {2, 0}, {3, 1}}), "", log_of(""), 0),
              Contains(HasSubstr("order begins anew 1 times, 0 returns")));
  EXPECT_THAT(faults(ledger_of({{0, 4}, {1, 1}, {2, 2}, {3, 0}}), "", log_of(""), 0),
              Contains(HasSubstr("no picture that was served")));
  const std::string complaint = "vsfind: info: camera library: GLib-GObject: g_object_unref: assertion failed\n";
  EXPECT_THAT(faults(ledger_of(good), csv, complaint + log_of(""), 0), Contains(HasSubstr("g_object_unref")));
  const std::string known = "vsfind: info: camera library: GLib: g_ascii_strcasecmp: assertion 's1 != NULL' failed\n";
  EXPECT_THAT(faults(ledger_of(good), csv, known + log_of(""), 0), IsEmpty());
  Ledger torn = ledger_of({});
  torn.add(line_of(0, 0).substr(0, 30));
  EXPECT_THAT(torn.faults(), Contains(HasSubstr("torn row")));
}

}  // namespace
}  // namespace vsfind::test
