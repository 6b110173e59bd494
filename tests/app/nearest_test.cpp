#include "app/nearest.h"

#include <gmock/gmock.h>

namespace vsfind {
namespace {

TEST(Nearest, CountsInsertionsDeletionsReplacementsAndSwaps) {
  EXPECT_EQ(edit_distance("angle", "angle"), 0U);
  EXPECT_EQ(edit_distance("", "abc"), 3U);
  EXPECT_EQ(edit_distance("angel", "angle"), 1U);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
}

TEST(Nearest, NamesOnlyWhatIsClose) {
  const std::vector<std::string> known{"min_score", "max_instances", "angle"};
  EXPECT_EQ(nearest_name("min_scoer", known), "min_score");
  EXPECT_EQ(nearest_name("max_instance", known), "max_instances");
  EXPECT_EQ(nearest_name("colour", known), "");
  EXPECT_EQ(nearest_name(std::string(100000, 'a'), known), "");
  EXPECT_EQ(did_you_mean("angel", known), " (did you mean angle?)");
  EXPECT_EQ(did_you_mean("colour", known), "");
}

}  // namespace
}  // namespace vsfind
