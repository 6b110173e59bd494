#pragma once
/// @file
/// What the guest left, for the tests on the host.

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "acquisition/frame.h"
#include "acquisition/source.h"

namespace vsfind::test {

/// A recording of the guest, whole in memory.
struct GuestRecording {
  SourceInfo info;
  std::vector<Frame> frames;
};

/// What a step of the guest's left behind: FOLDER/NAME and an ending.
[[nodiscard]] std::string guest_file(const std::string& name);
[[nodiscard]] std::string guest_text(const std::string& name);
/// The exit code of a run; -1, and a failed test, where the step was not taken to its end.
[[nodiscard]] int guest_code(const std::string& name);
/// Fails the test where the recording is damaged or absent.
[[nodiscard]] GuestRecording guest_recording(const std::string& name);

/// Skips where there was no guest, with the reason.
class VividTest : public testing::Test {
 protected:
  void SetUp() override;
};
template <typename Parameter>
class VividTestWith : public VividTest, public testing::WithParamInterface<Parameter> {};

}  // namespace vsfind::test
