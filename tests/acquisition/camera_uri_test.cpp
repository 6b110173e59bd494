#include <gmock/gmock.h>

#include "acquisition/camera.h"
#include "acquisition/errors.h"
#include "tests/acquisition/support.h"

namespace vsfind {
namespace {

using Scheme = SourceUri::Scheme;
using test::complaint;
using testing::AllOf;
using testing::HasSubstr;

TEST(SourceUri, HasASchemeAndAName) {
  EXPECT_EQ(parse_source_uri("v4l2:/dev/video3").scheme, Scheme::v4l2);
  EXPECT_EQ(parse_source_uri("v4l2:/dev/video3").name, "/dev/video3");
  EXPECT_EQ(parse_source_uri("gige:192.168.1.5").scheme, Scheme::gige);
  EXPECT_EQ(parse_source_uri("gige:192.168.1.5").name, "192.168.1.5");
  EXPECT_EQ(parse_source_uri("gige:").name, "");
  EXPECT_EQ(parse_source_uri("file:a:b.y4m").scheme, Scheme::file);
  EXPECT_EQ(parse_source_uri("file:a:b.y4m").name, "a:b.y4m");
}

TEST(SourceUri, OthersAreRefusedWithTheAllowedOnes) {
  for (const std::string uri : {"", "/dev/video0", "usb:1", ":", "V4L2:/dev/video0", "v4l2:", "file:"}) {
    EXPECT_THAT(complaint<UsageError>([&] { static_cast<void>(parse_source_uri(uri)); }),
                AllOf(HasSubstr("'" + uri + "'"),
                      HasSubstr("v4l2:/dev/videoN, gige:NAME-OR-ADDRESS, gige: (the first one), file:SEQUENCE")));
  }
}

TEST(OpenSource, OpensARecording) {
  EXPECT_EQ(open_source("file:" VSFIND_TEST_DATA "/interlaced/conveyor.y4m", {})->info().width, 640);
  EXPECT_THAT(complaint<IoError>([] { static_cast<void>(open_source("file:/nowhere.y4m", {})); }),
              HasSubstr("/nowhere.y4m"));
}

}  // namespace
}  // namespace vsfind
