#include <gmock/gmock.h>

#include <filesystem>

#include "app/config.h"
#include "app/replay_options.h"

namespace vsfind {
namespace {

TEST(Examples, EveryConfigurationThatShipsIsTaken) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(VSFIND_SOURCE_DIR "/configs")) {
    if (entry.path().extension() != ".yaml") continue;
    SCOPED_TRACE(entry.path());
    ++count;
    ReplayRequest request;
    EXPECT_NO_THROW(apply_config(load_config(entry.path().string()), replay_settings(request)));
    EXPECT_FALSE(request.source.empty());
    EXPECT_FALSE(request.options.models.empty());
    EXPECT_NO_THROW(complete_run_options(request.options));
  }
  EXPECT_GE(count, 1);
}

}  // namespace
}  // namespace vsfind
