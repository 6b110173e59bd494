/// The shipped sequence is what the renderer makes, and moves as it says.
#include "render/sequence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>

#include "acquisition/image_file.h"
#include "acquisition/source.h"

namespace vsfind::render {
namespace {

const std::string folder = VSFIND_TEST_DATA "/interlaced";

/// Pixels that differ; the last place of exp() or log() may tip a rounding on another machine.
int differing(const ImageView& a, const ImageView& b, int most) {
  if (a.width != b.width || a.height != b.height || a.bits != b.bits) return a.width * a.height;
  int count = 0;
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      const int d = std::abs(a.at(x, y) - b.at(x, y));
      if (d > most) return a.width * a.height;
      count += d > 0 ? 1 : 0;
    }
  }
  return count;
}

TEST(Sequence, ShippedFramesAreTheRenderedOnes) {
  const auto source = open_sequence(folder + "/conveyor.y4m");
  EXPECT_EQ(source->info().width, 640);
  EXPECT_EQ(source->info().height, 480);
  EXPECT_EQ(source->info().order, FieldOrder::top_first);
  EXPECT_EQ(source->info().pixel_aspect.value(), 1.0);
  EXPECT_EQ(source->info().frame_rate.value(), 25.0);
  int count = 0;
  while (auto frame = source->next()) {
    if (count == 0 || count == sequence_empty_frame || count == sequence_frames - 1) {
      EXPECT_LE(differing(frame->image(), sequence_frame(count).view(), 1), 10) << count;
    }
    ++count;
  }
  EXPECT_EQ(count, sequence_frames);
  EXPECT_LE(differing(load_image(folder + "/training.png").view(), sequence_training().view(), 1), 10);
}

TEST(Sequence, ShippedTruthIsTheRenderedOne) {
  std::ifstream file(folder + "/truth.csv");
  std::string line;
  ASSERT_TRUE(std::getline(file, line));
  EXPECT_EQ(line, "frame,field,x,y,angle_deg");
  for (int frame = 0; frame < sequence_frames; ++frame) {
    for (const Field field : {Field::top, Field::bottom}) {
      ASSERT_TRUE(std::getline(file, line));
      const std::string start = std::to_string(frame) + "," + name(field) + ",";
      ASSERT_EQ(line.substr(0, start.size()), start);
      const auto pose = sequence_truth(frame, field);
      if (!pose) {
        EXPECT_EQ(line.substr(start.size()), ",,");
        continue;
      }
      double x = 0.0, y = 0.0, angle = 0.0;
      ASSERT_EQ(std::sscanf(line.c_str() + start.size(), "%lf,%lf,%lf", &x, &y, &angle), 3);
      EXPECT_NEAR(x, pose->x, 1e-5);
      EXPECT_NEAR(y, pose->y, 1e-5);
      EXPECT_NEAR(angle, pose->angle_deg, 1e-5);
    }
  }
  EXPECT_FALSE(std::getline(file, line));
}

TEST(Sequence, MovesAndTurnsBetweenFields) {
  for (int frame = 0; frame < sequence_frames; ++frame) {
    const auto top = sequence_truth(frame, Field::top);
    const auto bottom = sequence_truth(frame, Field::bottom);
    ASSERT_EQ(top.has_value(), frame != sequence_empty_frame);
    if (!top) continue;
    const double way = std::hypot(bottom->x - top->x, bottom->y - top->y);
    EXPECT_GT(way, 3.0);
    EXPECT_LT(way, 6.0);
    EXPECT_GT(bottom->angle_deg - top->angle_deg, 0.3);
    EXPECT_LT(bottom->angle_deg - top->angle_deg, 0.5);
  }
}

TEST(Sequence, IsSmallEnoughToShip) {
  std::ifstream file(folder + "/conveyor.y4m", std::ios::binary | std::ios::ate);
  EXPECT_LE(file.tellg(), 9'500'000);
}

}  // namespace
}  // namespace vsfind::render
