#include "app/live_options.h"

#include <gmock/gmock.h>

#include "acquisition/errors.h"
#include "tests/app/shell.h"

namespace vsfind {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

class LiveConfig : public testing::Test {
 protected:
  LiveRequest load(const std::string& text) {
    test::write_file(folder_ / "c.yaml", text);
    LiveRequest request;
    request.config = folder_ / "c.yaml";
    apply_live_config(request, live_settings(request));
    return request;
  }
  std::string complaint(const std::string& text) {
    try {
      static_cast<void>(load(text));
    } catch (const UsageError& error) {
      return error.what();
    }
    return {};
  }

  test::TemporaryFolder folder_;
};

TEST_F(LiveConfig, OneSource) {
  const LiveRequest request = load(
      "source: gige:10.0.0.2\nmodel: part.vsm\nsize: 640x480\noffset: [8, 16]\nexposure: 1500\ngain: 2.5\n"
      "control: {BlackLevel: 3, GammaEnable: true}\ntrigger: Line1\nrotate: [day, 5MB]\nrotate_keep: "
      "30\ngive_up_after: 60\n"
      "packet_socket: off\nrecord: rec.y4m\nframes: 7\nseconds: 1.5\n");
  EXPECT_THAT(request.uris, ElementsAre("gige:10.0.0.2"));
  const CameraSettings& camera = request.common.camera;
  EXPECT_EQ(camera.width, 640);
  EXPECT_EQ(camera.height, 480);
  EXPECT_EQ(camera.offset_x, 8);
  EXPECT_EQ(camera.offset_y, 16);
  EXPECT_EQ(camera.exposure_us, 1500.0);
  EXPECT_EQ(camera.gain, 2.5);
  EXPECT_EQ(camera.trigger, "Line1");
  EXPECT_EQ(camera.packet_socket, false);
  ASSERT_THAT(camera.controls, SizeIs(2));
  EXPECT_EQ(camera.controls[0].name, "BlackLevel");
  EXPECT_EQ(camera.controls[0].value, "3");
  EXPECT_EQ(camera.controls[1].value, "true");
  EXPECT_TRUE(request.row_files.daily);
  EXPECT_EQ(request.row_files.max_bytes, 5'000'000U);
  EXPECT_EQ(request.give_up_after, 60.0);
  EXPECT_EQ(request.common.record, folder_ / "rec.y4m");
  EXPECT_EQ(request.frames, 7U);
  EXPECT_EQ(request.seconds, 1.5);
  EXPECT_EQ(request.row_files.keep, 30U);
}

TEST_F(LiveConfig, SourcesHaveTheirOwnAndTheCommon) {
  const LiveRequest request = load(
      "model: common.vsm\nmin_score: 0.7\ncsv: rows.csv\nexposure: 100\nsources:\n"
      "  - source: gige:10.0.0.2\n    model: [left.vsm, other.vsm]\n    exposure: 200\n"
      "  - source: file:right.y4m\n    calibration: right.yaml\n    control: [A=1, B=2]\n");
  ASSERT_THAT(request.sources, SizeIs(2));
  const LiveSource& left = request.sources[0];
  const LiveSource& right = request.sources[1];
  EXPECT_EQ(left.uri, "gige:10.0.0.2");
  EXPECT_THAT(left.options.models, ElementsAre(folder_ / "left.vsm", folder_ / "other.vsm"));
  EXPECT_EQ(left.camera.exposure_us, 200.0);
  EXPECT_EQ(left.options.search.min_score, 0.7);
  EXPECT_EQ(right.uri, "file:" + (folder_ / "right.y4m"));
  EXPECT_THAT(right.options.models, ElementsAre(folder_ / "common.vsm"));
  EXPECT_EQ(right.camera.exposure_us, 100.0);
  EXPECT_EQ(right.options.mapping.calibration, folder_ / "right.yaml");
  EXPECT_THAT(right.camera.controls, SizeIs(2));
}

TEST_F(LiveConfig, ComplaintsNameLineAndKey) {
  EXPECT_THAT(complaint("sources:\n  - source: gige:a\n    csv: rows.csv\n"),
              AllOf(HasSubstr("c.yaml:3: key csv is not known"), HasSubstr("model")));
  EXPECT_THAT(complaint("sources:\n  - source: gige:a\n    report: pages\n"),
              HasSubstr("c.yaml:3: key report is not known"));
  EXPECT_THAT(complaint("sources:\n  - model: a\n"), HasSubstr("c.yaml:1: key sources: an item has no source"));
  EXPECT_THAT(complaint("sources: gige:a\n"), HasSubstr("is not a list of sources"));
  EXPECT_THAT(complaint("source: gige:a\nsources:\n  - source: gige:a\n"), HasSubstr("together with source"));
  EXPECT_THAT(complaint("sources:\n  - source: gige:a\n    source: a\n"), HasSubstr("stands in line 2 already"));
  EXPECT_THAT(complaint("sources:\n  - source: gige:a\n  - gige:b\n"), HasSubstr("plain values and keys alike"));
  EXPECT_THAT(complaint("sources:\n  - source: gige:a\n    model: {a: 1}\n"), HasSubstr("holds keys of its own"));
  EXPECT_THAT(complaint("exposure: long\n"), HasSubstr("c.yaml:1: key exposure: 'long' is not a number"));
  EXPECT_THAT(complaint("control: Gain\n"), HasSubstr("'Gain' is not NAME=VALUE"));
  EXPECT_THAT(complaint("size: 640\n"), HasSubstr("'640' is not WxH"));
  EXPECT_THAT(complaint("rotate: 5\n"), HasSubstr("allowed: day, or a size"));
  EXPECT_THAT(complaint("rotate_keep: 0\n"), HasSubstr("key rotate_keep"));
  EXPECT_THAT(complaint("exposre: 5\n"), HasSubstr("exposure"));
}

}  // namespace
}  // namespace vsfind
