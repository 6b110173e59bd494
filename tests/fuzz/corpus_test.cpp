/// Every file of the corpora, those that once were a fault among them, fed to the entry points of the fuzzers.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "tests/fuzz/entry_points.h"

namespace vsfind::fuzz {
namespace {

class Corpus : public testing::TestWithParam<EntryPoint> {};

TEST_P(Corpus, IsTakenOrRefused) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry :
       std::filesystem::directory_iterator(VSFIND_SOURCE_DIR "/tests/fuzz/corpus/" + std::string(GetParam().name))) {
    files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  ASSERT_FALSE(files.empty());
  bool any_taken = false;
  for (const auto& path : files) {
    SCOPED_TRACE(path);
    std::ifstream in(path, std::ios::binary);
    std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    EXPECT_NO_THROW(any_taken = GetParam().feed(bytes) || any_taken);
    // A file cut off anywhere is the commonest damage.
    for (const std::size_t part : {3U, 2U}) {
      const std::size_t size = bytes.size() - bytes.size() / part;
      EXPECT_NO_THROW(GetParam().feed(Bytes(bytes).first(size))) << "cut to " << size << " bytes";
    }
  }
  // A format that has moved on would leave the fuzzers in front of a closed door.
  EXPECT_TRUE(any_taken);
}

INSTANTIATE_TEST_SUITE_P(Fuzz, Corpus, testing::ValuesIn(entry_points()),
                         [](const auto& one) { return std::string(one.param.name); });

}  // namespace
}  // namespace vsfind::fuzz
