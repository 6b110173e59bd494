#include <gmock/gmock.h>

#include <filesystem>
#include <regex>

#include "acquisition/camera.h"
#include "app/config.h"
#include "app/live_options.h"
#include "app/replay_options.h"
#include "tests/app/shell.h"

namespace vsfind {
namespace {

/// The command that an example is for stands in its first line: "… : vsfind COMMAND --config configs/NAME".
bool is_for(const std::string& command, const std::filesystem::path& path) {
  const auto lines = test::lines_of(test::read_file(path.string()));
  return !lines.empty() && lines[0].ends_with("vsfind " + command + " --config configs/" + path.filename().string());
}

void expect_replay_taken(const std::string& path) {
  ReplayRequest request;
  EXPECT_NO_THROW(apply_config(load_config(path), replay_settings(request)));
  EXPECT_FALSE(request.source.empty());
  EXPECT_FALSE(request.options.models.empty());
  EXPECT_NO_THROW(complete_run_options(request.options));
}

void expect_live_taken(const std::string& path) {
  LiveRequest request;
  request.config = path;
  EXPECT_NO_THROW(apply_live_config(request, live_settings(request)));
  for (const auto& uri : request.uris) {
    request.sources.push_back(request.common);
    request.sources.back().uri = uri;
  }
  EXPECT_FALSE(request.sources.empty());
  for (auto& source : request.sources) {
    EXPECT_NO_THROW(static_cast<void>(parse_source_uri(source.uri)));
    EXPECT_FALSE(source.options.models.empty());
    EXPECT_NO_THROW(complete_run_options(source.options));
  }
}

TEST(Examples, EveryConfigurationThatShipsIsTaken) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(VSFIND_SOURCE_DIR "/configs")) {
    if (entry.path().extension() != ".yaml") continue;
    SCOPED_TRACE(entry.path());
    ++count;
    const std::string path = entry.path().string();
    if (is_for("replay", path)) {
      expect_replay_taken(path);
    } else {
      EXPECT_TRUE(is_for("live", path)) << "its first line does not say which command it is for";
      expect_live_taken(path);
    }
  }
  EXPECT_GE(count, 3);
}

/// An example with every commented key switched on as well: a key that is only explained has to be right, too.
TEST(Examples, EveryKeyThatIsOnlyExplainedIsKnown) {
  for (const std::string name : {"gige.yaml"}) {
    SCOPED_TRACE(name);
    // "# key: value" and, below a key, "#   Name: value", but no sentence with a colon.
    const std::regex explained("# ( *[A-Za-z_]+:( .*)?)");
    std::string text;
    int count = 0;
    for (const auto& line : test::lines_of(test::read_file(VSFIND_SOURCE_DIR "/configs/" + name))) {
      std::smatch match;
      const bool is_key = std::regex_match(line, match, explained);
      text += (is_key ? match[1].str() : line) + "\n";
      count += is_key ? 1 : 0;
    }
    EXPECT_GT(count, 8);
    test::TemporaryFolder folder;
    test::write_file(folder / name, text);
    expect_live_taken(folder / name);
  }
}

}  // namespace
}  // namespace vsfind
