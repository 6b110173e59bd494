#include "tests/acquisition/vivid/results.h"

#include <filesystem>
#include <fstream>
#include <iterator>

#include "acquisition/errors.h"
#include "acquisition/recording.h"

namespace vsfind::test {

std::string guest_file(const std::string& name) { return std::string(VIVID_RESULTS) + "/" + name; }

std::string guest_text(const std::string& name) {
  std::ifstream file(guest_file(name));
  return {std::istreambuf_iterator<char>(file), {}};
}

int guest_code(const std::string& name) {
  EXPECT_EQ(guest_text(name + ".failed"), "");
  std::ifstream file(guest_file(name + ".code"));
  int code = -1;
  EXPECT_TRUE(file >> code) << name << " was not run";
  return code;
}

GuestRecording guest_recording(const std::string& name) {
  GuestRecording recording;
  try {
    const auto source = open_y4m(guest_file(name + ".y4m"));
    recording.info = source->info();
    while (auto frame = source->next()) recording.frames.push_back(std::move(*frame));
  } catch (const IoError& error) {
    ADD_FAILURE() << error.what() << "\n" << guest_text(name + ".err");
  }
  return recording;
}

void VividTest::SetUp() {
  if (const std::string why = guest_text("skipped"); !why.empty()) GTEST_SKIP() << why;
  ASSERT_TRUE(std::filesystem::exists(guest_file("code"))) << "the guest has not run to its end (test vivid.guest)";
}

}  // namespace vsfind::test
