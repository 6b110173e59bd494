/// A model survives its file; a damaged file is refused in one line.
#include "finder/model_file.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "acquisition/errors.h"
#include "app/render/patterns.h"
#include "app/render/sensor.h"
#include "finder/train.h"

namespace vsfind {
namespace {

class ModelFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) / testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::create_directories(folder_);
    path_ = (folder_ / "part.vsm").string();
    render::Scene scene;
    scene.width = 160;
    scene.height = 140;
    scene.items.push_back({render::artwork(2, 90.0, 80.0), {80.0, 70.0, 0.0, 1.0, 1.0}});
    const render::Picture picture = render::develop(render::expose(scene, 0.7), {});
    TrainOptions options;
    options.name = "part \"7\"";
    options.roi = {35, 30, 90, 80};
    options.angle_deg = {-12.5, 30.0};
    options.accuracy = 10;
    pattern_ = train(picture.view(), Mapping(), options);
    save_model(pattern_, path_);
    std::ifstream in(path_, std::ios::binary);
    std::ostringstream all;
    all << in.rdbuf();
    text_ = all.str();
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  void write(const std::string& text) const { std::ofstream(path_, std::ios::binary | std::ios::trunc) << text; }

  [[nodiscard]] std::string complaint() const {
    try {
      static_cast<void>(load_model(path_));
    } catch (const UsageError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(path_));
      EXPECT_THAT(error.what(), testing::Not(testing::HasSubstr("\n")));
      return error.what();
    }
    return "";
  }
  /// The file with its first `from` replaced.
  [[nodiscard]] std::string changed(const std::string& from, const std::string& to) const {
    std::string text = text_;
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    if (at != std::string::npos) text.replace(at, from.size(), to);
    return text;
  }

  std::filesystem::path folder_;
  std::string path_;
  std::string text_;
  Pattern pattern_;
};

TEST_F(ModelFile, ComesBackAsItWas) {
  const Pattern back = load_model(path_);
  EXPECT_EQ(back.name, pattern_.name);
  EXPECT_EQ(back.angle_deg.min, -12.5);
  EXPECT_EQ(back.angle_deg.max, 30.0);
  EXPECT_EQ(back.top_level, pattern_.top_level);
  EXPECT_EQ(back.angle_step_deg, pattern_.angle_step_deg);
  EXPECT_EQ(back.image.grey, pattern_.image.grey);
  EXPECT_EQ(back.image.mask, pattern_.image.mask);
  ASSERT_EQ(back.sets.size(), pattern_.sets.size());
  for (std::size_t s = 0; s < back.sets.size(); ++s) {
    EXPECT_EQ(back.sets[s].use, pattern_.sets[s].use);
    ASSERT_EQ(back.sets[s].points.size(), pattern_.sets[s].points.size());
    for (std::size_t k = 0; k < back.sets[s].points.size(); ++k) {
      EXPECT_EQ(back.sets[s].points[k].x, pattern_.sets[s].points[k].x);
      EXPECT_EQ(back.sets[s].points[k].value, pattern_.sets[s].points[k].value);
      EXPECT_EQ(back.sets[s].points[k].gradient_y, pattern_.sets[s].points[k].gradient_y);
    }
  }
}

TEST_F(ModelFile, CutOffAnywhereItIsRefused) {
  for (std::size_t length = 0; length + 2 < text_.size(); length += 1 + text_.size() / 60) {
    write(text_.substr(0, length));
    EXPECT_THAT(complaint(), testing::HasSubstr("no vsfind model")) << length;
  }
}

TEST_F(ModelFile, EveryBadValueIsNamed) {
  write(changed("\"version\":1", "\"version\":2"));
  EXPECT_THAT(complaint(), testing::HasSubstr("newer"));
  write(changed("\"accuracy\":10", "\"accuracy\":1000"));
  EXPECT_THAT(complaint(), testing::HasSubstr("'pattern.accuracy'"));
  write(changed("\"accuracy\":10", "\"accuracy\":\"ten\""));
  EXPECT_THAT(complaint(), testing::HasSubstr("whole number"));
  write(changed("\"accuracy\":10", "\"accuracy\":11"));
  EXPECT_THAT(complaint(), testing::HasSubstr("checksum"));
  write(changed("\"edges\":false", "\"edges\":true"));  // whose threshold is 0
  EXPECT_THAT(complaint(), testing::HasSubstr("'pattern.edge_threshold'"));
  write(changed("\"polarity\":\"same\"", "\"polarity\":\"both\""));
  EXPECT_THAT(complaint(), testing::HasSubstr("same, reversed, any"));
  write(changed("\"pitch\"", "\"pitsch\""));
  EXPECT_THAT(complaint(), testing::HasSubstr("'pattern.pitch' is missing"));
  write(changed("\"width\":98", "\"width\":999999999"));
  EXPECT_THAT(complaint(), testing::HasSubstr("image.width"));
  // Few characters that would make the search try hundreds of millions of copies.
  std::string wide = changed("\"angle_deg\":[-12.5,30.0]", "\"angle_deg\":[-180.0,180.0]");
  for (const auto& [from, to] : {std::pair("\"scale_x\":[1.0,1.0]", "\"scale_x\":[0.5,2.0]"),
                                 {"\"scale_y\":[1.0,1.0]", "\"scale_y\":[0.5,2.0]"},
                                 {"\"scale_step\":0.0", "\"scale_step\":0.005"}}) {
    const auto at = wide.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    wide.replace(at, std::string_view(from).size(), to);
  }
  write(wide);
  EXPECT_THAT(complaint(), testing::AllOf(testing::HasSubstr("angle_step_deg"), testing::HasSubstr("up to 65535")));
  write("[1,2,3]");
  EXPECT_THAT(complaint(), testing::HasSubstr("no vsfind model"));
  write(std::string(100000, '['));
  EXPECT_THAT(complaint(), testing::HasSubstr("no vsfind model"));
}

// What an earlier vsfind did not know of has a default.
TEST_F(ModelFile, OfAnEarlierVsfindIsRead) {
  auto file = nlohmann::ordered_json::parse(text_);
  ASSERT_EQ(file["pattern"].erase("from_field"), 1U);
  ASSERT_EQ(file["pattern"]["report"].erase("impostor"), 1U);
  const std::string body = file["pattern"].dump();
  const auto* bytes = reinterpret_cast<const Bytef*>(body.data());
  file["checksum"] = fmt::format("{:08x}", crc32_z(crc32_z(0, nullptr, 0), bytes, body.size()));
  write(file.dump());
  const Pattern old = load_model(path_);
  EXPECT_FALSE(old.from_field);
  EXPECT_EQ(old.name, pattern_.name);
  EXPECT_EQ(old.sets.size(), pattern_.sets.size());
}

TEST_F(ModelFile, FilesThatCannotBeReadOrWrittenAreInputAndOutput) {
  EXPECT_THROW(static_cast<void>(load_model((folder_ / "none.vsm").string())), IoError);
  EXPECT_THROW(static_cast<void>(load_model(folder_.string())), IoError);
  EXPECT_THROW(save_model(pattern_, (folder_ / "no" / "such" / "part.vsm").string()), IoError);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "part.vsm.part"));
}

}  // namespace
}  // namespace vsfind
