#include "app/overlay.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "acquisition/errors.h"
#include "app/drawing.h"
#include "app/model_picture.h"
#include "tests/app/shell.h"

namespace vsfind {
namespace {

/// Mean position of the pixels that differ in colour from grey, weighted by how much.
Eigen::Vector2d centre_of_drawing(const cv::Mat& picture, const cv::Rect& within) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double weights = 0.0;
  for (int y = within.y; y < within.y + within.height; ++y) {
    for (int x = within.x; x < within.x + within.width; ++x) {
      const auto& pixel = picture.at<cv::Vec3b>(y, x);
      const double weight = cv::norm(cv::Vec3d(pixel) - cv::Vec3d(100, 100, 100));
      sum += weight * Eigen::Vector2d(x, y);
      weights += weight;
    }
  }
  return sum / weights;
}

GreyPicture plain(int width, int height) {
  return {width, height, std::vector<std::uint8_t>(static_cast<std::size_t>(width * height), 100)};
}

TEST(Drawing, ASubPixelCrossLiesWhereItIsAskedFor) {
  for (const double shift : {0.0, 0.25, 0.5, 0.75}) {
    cv::Mat picture(60, 60, CV_8UC3, cv::Scalar(100, 100, 100));
    draw_plus(picture, {30.0 + shift, 25.0 - shift}, 6.0, {255, 255, 255});
    const Eigen::Vector2d centre = centre_of_drawing(picture, {0, 0, 60, 60});
    EXPECT_NEAR(centre.x(), 30.0 + shift, 0.1);
    EXPECT_NEAR(centre.y(), 25.0 - shift, 0.1);
  }
}

TEST(Drawing, FarAndImpossiblePlacesDoNoHarm) {
  cv::Mat picture(20, 20, CV_8UC3, cv::Scalar(100, 100, 100));
  draw_line(picture, {-1e12, 3.0}, {1e12, 3.0}, {255, 255, 255});
  draw_line(picture, {std::nan(""), 3.0}, {5.0, 3.0}, {255, 255, 255});
  draw_plus(picture, {1e300, -1e300}, 5.0, {255, 255, 255});
  draw_arrow(picture, {5.0, 5.0}, {5.0, 5.0}, {100, 100, 100}, 3.0);
  EXPECT_EQ(cv::norm(picture, cv::Mat(20, 20, CV_8UC3, cv::Scalar(100, 100, 100)), cv::NORM_INF), 0.0);
}

TEST(Overlay, FieldRowsLieAtTheirFrameRows) {
  for (const Field field : {Field::top, Field::bottom}) {
    GreyPicture grey{1, 4, {10, 20, 40, 80}};
    const cv::Mat canvas = overlay_canvas(grey, field);
    ASSERT_EQ(canvas.rows, 8);
    const int first = first_line(field);
    for (int r = 0; r < 4; ++r) {
      EXPECT_EQ(canvas.at<cv::Vec3b>(2 * r + first, 0)[0], grey.pixels[static_cast<std::size_t>(r)]);
    }
    // The line between the field's rows 1 and 2.
    EXPECT_EQ(canvas.at<cv::Vec3b>(3 + first, 0)[0], 30);
  }
}

TEST(Overlay, OutlineFollowsThePose) {
  auto pattern = std::make_shared<Pattern>();
  pattern->name = "p";
  pattern->width = 40.0;
  pattern->height = 20.0;
  pattern->left = -20.0;
  pattern->top = -10.0;
  PictureResult picture;
  picture.patterns.resize(1);
  Match match;
  // A quarter turn: the outline's width is now its height. Pixels twice as wide as high: plane x is 2·frame x.
  match.pose = {200.0, 90.0, 90.0, 1.0, 1.0};
  match.frame_position = {100.0, 90.0};
  picture.patterns[0].matches = {match};
  cv::Mat canvas = overlay_canvas(plain(200, 180), Field::frame);
  draw_matches(canvas, picture, {pattern}, Mapping::from_pixel_aspect(2.0));
  const auto drawn = [&](int x, int y) {
    const auto& pixel = canvas.at<cv::Vec3b>(y, x);
    return pixel[1] > 150 && pixel[0] < 95 && pixel[2] < 95;  // the first pattern's green
  };
  // Plane corners (±10, ±20) around (200, 90): frame x from 95 to 105, y from 70 to 110.
  EXPECT_TRUE(drawn(95, 80));
  EXPECT_TRUE(drawn(105, 80));
  EXPECT_TRUE(drawn(98, 70));
  EXPECT_TRUE(drawn(102, 110));
  EXPECT_FALSE(drawn(93, 80));
  EXPECT_FALSE(drawn(98, 68));
}

TEST(Overlay, PointsLieAtTheirPlaces) {
  auto pattern = std::make_shared<Pattern>();
  pattern->width = pattern->height = 400.0;  // the outline far away
  pattern->left = pattern->top = -200.0;
  PatternPoint point;
  point.x = 30.0;
  point.y = 10.25;
  pattern->sets = {{0, PointUse::refine, {point}}};
  pattern->pitch = 1.0;
  PictureResult picture;
  picture.patterns.resize(1);
  Match match;
  match.pose = {300.0, 300.0, 180.0, 1.0, 1.0};
  match.frame_position = {300.0, 300.0};
  picture.patterns[0].matches = {match};
  cv::Mat canvas = overlay_canvas(plain(600, 600), Field::frame);
  draw_matches(canvas, picture, {pattern}, Mapping());
  const Eigen::Vector2d centre = centre_of_drawing(canvas, {263, 283, 14, 13});
  EXPECT_NEAR(centre.x(), 270.0, 0.15);
  EXPECT_NEAR(centre.y(), 289.75, 0.15);
}

TEST(Overlay, NamesSortBySourceFrameAndExposure) {
  EXPECT_EQ(overlay_name(0, 12, Field::frame, 0), "s0-00000012-frame.png");
  EXPECT_EQ(overlay_name(0, 12, Field::bottom, 0), "s0-00000012-a-bottom.png");
  EXPECT_LT(overlay_name(0, 12, Field::bottom, 0), overlay_name(0, 12, Field::top, 1));
  EXPECT_LT(overlay_name(0, 12, Field::top, 1), overlay_name(0, 100, Field::bottom, 0));
}

TEST(Overlay, WritesOnePicturePerSearch) {
  const test::TemporaryFolder folder;
  auto pattern = std::make_shared<Pattern>();
  pattern->name = "p";
  FrameResult result;
  result.info.sequence = 3;
  PictureResult picture;
  picture.patterns.resize(1);
  picture.field = Field::top;
  picture.grey = plain(64, 30);
  result.pictures = {picture, picture};
  result.pictures[1].field = Field::bottom;
  OverlayWriter(folder / "new/pictures").write(result, {pattern}, Mapping());
  const cv::Mat top = cv::imread(folder / "new/pictures/s0-00000003-a-top.png");
  EXPECT_EQ(top.size(), cv::Size(64, 60));
  EXPECT_TRUE(std::filesystem::exists(folder / "new/pictures/s0-00000003-b-bottom.png"));
  EXPECT_THROW(OverlayWriter(folder / "new/pictures/s0-00000003-a-top.png"), IoError);
}

TEST(ModelPicture, DrawsPointsAtTheirEnlargedPlaces) {
  Pattern pattern;
  pattern.name = "p";
  pattern.width = pattern.height = 30.0;
  pattern.left = pattern.top = -15.0;
  pattern.image.width = pattern.image.height = 60;
  pattern.image.origin_x = pattern.image.origin_y = 29.5;
  pattern.image.grey.assign(3600, 100 << 8);
  pattern.image.mask.assign(3600, 255);
  PatternPoint coarse;
  coarse.x = -8.0;
  coarse.y = 7.0;
  PatternPoint fine;
  fine.x = 8.5;
  fine.y = -6.5;
  PatternPoint outermost;
  outermost.x = 12.0;
  outermost.y = 11.0;
  PatternPoint followed;
  followed.x = -5.0;
  followed.y = -9.0;
  PatternPoint verified;
  verified.x = 3.0;
  verified.y = 4.0;
  pattern.sets = {{2, PointUse::search, {coarse}},
                  {0, PointUse::refine, {fine}},
                  {0, PointUse::outline, {outermost}},
                  {1, PointUse::follow, {followed}},
                  {0, PointUse::verify, {verified}}};
  int zoom = 0;
  const cv::Mat picture = model_picture(pattern, &zoom);
  ASSERT_EQ(zoom, 15);
  const auto place = [&](double x, double y) {
    return cv::Point(static_cast<int>(std::lround((29.5 + x + 0.5) * zoom - 0.5)),
                     static_cast<int>(std::lround((29.5 + y + 0.5) * zoom - 0.5)));
  };
  const auto brightness = [&](const cv::Point& p) { return cv::mean(picture(cv::Rect(p.x, p.y, 1, 1)))[1]; };
  const cv::Point c = place(-8.0, 7.0);
  const cv::Point f = place(8.5, -6.5);
  EXPECT_LT(brightness(c), 60.0);  // black x …
  EXPECT_LT(brightness(c + cv::Point(3, 3)), 60.0);
  EXPECT_GT(brightness(c + cv::Point(6, 6)), 120.0);  // … with a white rim
  EXPECT_GT(brightness(f), 200.0);                    // white + …
  EXPECT_GT(brightness(f + cv::Point(3, 0)), 150.0);
  EXPECT_LT(brightness(f + cv::Point(3, 3)), 105.0);  // … whose diagonal is not drawn
  const auto colour = [&](const cv::Point& p) { return picture.at<cv::Vec3b>(p); };
  const cv::Vec3b yellow = colour(place(12.0, 11.0));
  EXPECT_GT(std::min(yellow[1], yellow[2]), yellow[0] + 60);
  // The other uses in the picture to the right, and only there.
  const cv::Point right(60 * zoom + 8, 0);
  const cv::Vec3b red = colour(place(3.0, 4.0) + right);
  EXPECT_GT(red[2], red[1] + 60);
  EXPECT_EQ(colour(place(3.0, 4.0)), cv::Vec3b(100, 100, 100));
  const cv::Vec3b side = colour(place(-5.0, -9.0) + right + cv::Point(3, 0));
  EXPECT_GT(*std::max_element(side.val, side.val + 3) - *std::min_element(side.val, side.val + 3), 40);
}

}  // namespace
}  // namespace vsfind
