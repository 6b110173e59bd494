#include "acquisition/image_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "acquisition/errors.h"
#include "acquisition/image_probe.h"
#include "tests/acquisition/support.h"

namespace vsfind {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;
using namespace std::string_literals;

/// A random picture; `type` as of OpenCV.
cv::Mat random_mat(int type, int width = 37, int height = 23) {
  cv::Mat mat(height, width, type);
  cv::RNG random(1);
  random.fill(mat, cv::RNG::UNIFORM, 0, mat.depth() == CV_8U ? 256 : 65536);
  return mat;
}

std::string encoded(const std::string& ending, const cv::Mat& mat) {
  std::vector<unsigned char> bytes;
  cv::imencode(ending, mat, bytes);
  return {bytes.begin(), bytes.end()};
}

class ImageFile : public testing::Test {
 protected:
  Image load(std::string_view bytes) {
    test::write_bytes(path_, bytes);
    return load_image(path_);
  }
  /// What is said about a file of these bytes, behind its name; empty where it is read. Nothing else may be written.
  std::string refusal(std::string_view bytes) {
    test::write_bytes(path_, bytes);
    testing::internal::CaptureStderr();
    const std::string said = test::complaint<IoError>([&] { static_cast<void>(load_image(path_)); });
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    if (said.empty()) return said;
    EXPECT_THAT(said, AllOf(StartsWith(path_ + ": "), Not(HasSubstr("\n"))));
    return said.substr(path_.size() + 2);
  }
  test::TemporaryFolder folder_;
  std::string path_ = folder_.file("x.png");  // of any format: the content tells it
};

TEST_F(ImageFile, ReadsGreyOfEveryFormat) {
  for (const auto& [ending, type] :
       {std::pair{".png", CV_8UC1}, std::pair{".png", CV_16UC1}, std::pair{".tif", CV_8UC1},
        std::pair{".tif", CV_16UC1}, std::pair{".bmp", CV_8UC1}, std::pair{".pgm", CV_8UC1},
        std::pair{".pgm", CV_16UC1}}) {
    const cv::Mat mat = random_mat(type);
    const Image image = load(encoded(ending, mat));
    const ImageView& view = image.view();
    ASSERT_EQ(view.width, 37) << ending;
    ASSERT_EQ(view.height, 23) << ending;
    ASSERT_EQ(view.bits, type == CV_8UC1 ? 8 : 16) << ending;
    for (int y = 0; y < 23; ++y) {
      for (int x = 0; x < 37; ++x)
        ASSERT_EQ(view.at(x, y), type == CV_8UC1 ? mat.at<std::uint8_t>(y, x) : mat.at<std::uint16_t>(y, x)) << ending;
    }
  }
}

TEST_F(ImageFile, ColourBecomesLuma) {
  for (const auto& [ending, type] :
       {std::pair{".png", CV_8UC3}, std::pair{".png", CV_8UC4}, std::pair{".png", CV_16UC3},
        std::pair{".png", CV_16UC4}, std::pair{".tif", CV_8UC3}, std::pair{".tif", CV_16UC3},
        std::pair{".bmp", CV_8UC3}, std::pair{".ppm", CV_8UC3}}) {
    const cv::Mat mat = random_mat(type);
    const Image image = load(encoded(ending, mat));
    const bool deep = mat.depth() == CV_16U;
    ASSERT_EQ(image.view().bits, deep ? 16 : 8);
    for (int y = 0; y < 23; ++y) {
      for (int x = 0; x < 37; ++x) {
        const auto channel = [&](int c) {
          return deep ? mat.ptr<std::uint16_t>(y)[x * mat.channels() + c]
                      : mat.ptr<std::uint8_t>(y)[x * mat.channels() + c];
        };
        const double luma = 0.114 * channel(0) + 0.587 * channel(1) + 0.299 * channel(2);
        ASSERT_NEAR(image.view().at(x, y), luma, deep ? 2.0 : 0.6) << ending << " type " << type;
      }
    }
  }
}

TEST_F(ImageFile, ReadsJpeg) {
  cv::Mat mat(64, 80, CV_8UC3, cv::Scalar(200, 100, 50));
  const Image image = load(encoded(".jpg", mat));
  EXPECT_EQ(image.view().width, 80);
  EXPECT_EQ(image.view().bits, 8);
  EXPECT_NEAR(image.view().at(40, 30), 0.114 * 200 + 0.587 * 100 + 0.299 * 50, 1.5);
}

TEST_F(ImageFile, AJpegIsDamagedWhereItsDecoderWouldOnlyWarn) {
  std::string jpeg = encoded(".jpg", random_mat(CV_8UC1, 80, 64));
  jpeg.replace(jpeg.size() / 2, 2, "\xff\xd9"s);  // ends early
  EXPECT_THAT(refusal(jpeg), StartsWith("is damaged: "));
}

TEST_F(ImageFile, ReadsTextPnmAndItsDepth) {
  const Image grey = load("P2\n# a comment\n3 2\n# another\n255\n0 1 2\n3 4 255\n");
  EXPECT_EQ(grey.view().at(2, 1), 255);
  EXPECT_EQ(grey.view().at(1, 0), 1);
  const Image ten = load("P5 2 1 1023\n\x03\xff\x01\x02"s);
  EXPECT_EQ(ten.view().bits, 10);
  EXPECT_EQ(ten.view().at(0, 0), 1023);
  EXPECT_EQ(ten.view().at(1, 0), 0x102);
  EXPECT_EQ(load("P5 2 1 1000\n\x03\xe8\x01\x02"s).view().bits, 16);
}

TEST_F(ImageFile, ColourProfilesOfPngsAreOfNoInterest) {
  std::string png = encoded(".png", random_mat(CV_8UC1));
  // A broken profile behind the header: libpng would print a warning.
  const std::string chunk = "iCCPbroken";
  const auto sum = static_cast<std::uint32_t>(
      crc32(0, reinterpret_cast<const Bytef*>(chunk.data()), static_cast<uInt>(chunk.size())));
  std::string whole = "\0\0\0\x06"s + chunk;
  for (unsigned shift = 32; shift > 0; shift -= 8) whole += static_cast<char>(sum >> (shift - 8U));
  png.insert(33, whole);
  EXPECT_EQ(refusal(png), "");
  EXPECT_EQ(load(png).view().at(3, 3), random_mat(CV_8UC1).at<std::uint8_t>(3, 3));
}

TEST_F(ImageFile, CopiesShareTheirPixelsAndOutliveTheFile) {
  Image copy;
  {
    const Image image = load(encoded(".png", random_mat(CV_8UC1)));
    copy = image;
    EXPECT_EQ(copy.view().data, image.view().data);
  }
  EXPECT_EQ(copy.view().at(3, 3), random_mat(CV_8UC1).at<std::uint8_t>(3, 3));
}

TEST_F(ImageFile, CutOffFilesAreRefused) {
  for (const auto* ending : {".png", ".jpg", ".bmp", ".pgm", ".tif"}) {
    const std::string whole = encoded(ending, random_mat(CV_8UC1));
    EXPECT_EQ(refusal(whole), "") << ending;
    for (const std::size_t size :
         {whole.size() - 1, whole.size() * 2 / 3, whole.size() / 3, std::size_t{20}, std::size_t{3}}) {
      if (ending == ".tif"s && size == whole.size() - 1) continue;  // the end of its directory is of no use
      EXPECT_NE(refusal(whole.substr(0, size)), "") << ending << " of " << size << " bytes";
    }
  }
}

TEST_F(ImageFile, SaysWhatIsWrong) {
  EXPECT_EQ(refusal(""), "is empty");
  EXPECT_EQ(refusal("hello"), "is no image that can be read: PNG, JPEG, TIFF, BMP and PNM (PGM, PPM, PBM) can");
  EXPECT_EQ(refusal("GIF89a and more"),
            "is no image that can be read: PNG, JPEG, TIFF, BMP and PNM (PGM, PPM, PBM) can");
  EXPECT_EQ(refusal("P5 0 4 255\n"), "is damaged: its size is 0x4 pixels");
  EXPECT_EQ(refusal("P5 4 4 70000\n0123456789abcdef"), "is damaged: its maximum is 70000, allowed are 1 to 65535");
  EXPECT_EQ(refusal("P5 4 -4 255\n0123456789abcdef"), "is damaged: a number is missing in its header");
  EXPECT_EQ(refusal("P5 99999999999999999999 99999999999999999999 255\n0"), "is cut off");
  std::string png = encoded(".png", random_mat(CV_8UC1));
  png[png.size() / 2] ^= 1;
  EXPECT_THAT(refusal(png), HasSubstr("is damaged: wrong check sum at byte"));
  EXPECT_EQ(test::complaint<IoError>([&] { static_cast<void>(load_image(folder_.path())); }),
            folder_.path() + ": cannot be opened: Is a directory");
  EXPECT_EQ(test::complaint<IoError>([&] { static_cast<void>(load_image("/nonexistent.png")); }),
            "/nonexistent.png: cannot be opened: No such file or directory");
  EXPECT_THAT(test::complaint<IoError>([&] { static_cast<void>(load_image("/dev/zero")); }),
              HasSubstr("is too large for an image"));
}

TEST_F(ImageFile, BombsAreRefusedBeforeTheyAreDecoded) {
  // Black pictures of a few hundred kilobytes at most that would need gigabytes.
  const auto mono_bitmap = "P4 65536 65536\n";
  EXPECT_EQ(refusal(mono_bitmap), "is cut off");
  std::string bmp = encoded(".bmp", random_mat(CV_8UC1));
  bmp.replace(18, 4, "\0\0\2\0"s);  // 131072 wide
  EXPECT_EQ(refusal(bmp), "is cut off");
  bmp[30] = 1;  // and run-length coded, so that the file may be short
  EXPECT_EQ(refusal(bmp), "has 131072x23 pixels: allowed are 65536 either way and 268435456 together");
  std::string tiff = encoded(".tif", random_mat(CV_8UC1));
  const std::size_t width = tiff.find("\x00\x01\x03\x00\x01\x00\x00\x00\x25\x00"s);
  ASSERT_NE(width, std::string::npos);
  tiff.replace(width, 12, "\x00\x01\x04\x00\x01\x00\x00\x00\x00\x00\x00\x10"s);
  EXPECT_THAT(refusal(tiff), StartsWith("has 268435456x23 pixels"));
  // Where its strips are, is not told: the decoder would take them for black.
  tiff = encoded(".tif", random_mat(CV_8UC1));
  const std::size_t offsets = tiff.find("\x11\x01\x04\x00"s);
  ASSERT_NE(offsets, std::string::npos);
  std::string without = tiff;
  without[offsets + 4] = 0;
  EXPECT_EQ(refusal(without), "is damaged: 0 of its 1 TIFF strips are told");
  std::string beyond = tiff;
  beyond[offsets + 10] = 0x7f;
  EXPECT_EQ(refusal(beyond), "is cut off");
  const std::size_t counts = tiff.find("\x17\x01\x04\x00"s);
  ASSERT_NE(counts, std::string::npos);
  std::string empty = tiff;
  empty.replace(counts + 8, 4, 4, '\0');
  EXPECT_EQ(refusal(empty), "is damaged: TIFF strip 0 is empty");
  std::string jpeg = encoded(".jpg", random_mat(CV_8UC1));
  const std::size_t frame = jpeg.find("\xff\xc0"s);
  ASSERT_NE(frame, std::string::npos);
  jpeg.replace(frame + 5, 4, "\xff\xff\xff\xff"s);
  EXPECT_THAT(refusal(jpeg), StartsWith("has 65535x65535 pixels"));
}

TEST_F(ImageFile, PixelsOfOtherTypesAreRefused) {
  EXPECT_EQ(refusal(encoded(".tif", random_mat(CV_32FC1))),
            "has pixels of neither 8 nor 16 bits: no others are allowed");
}

/// Whatever is changed: an image or one line, within bounds.
TEST_F(ImageFile, WithstandsRandomDamage) {
  std::mt19937 random(3);
  std::map<bool, int> outcomes;
  for (const auto* ending : {".png", ".jpg", ".bmp", ".ppm", ".tif"}) {
    const std::string whole = encoded(ending, random_mat(CV_8UC3, 16, 12));
    for (int i = 0; i < 60; ++i) {
      std::string bytes = whole;
      const std::size_t reach = i % 2 == 0 ? std::min<std::size_t>(bytes.size(), 64) : bytes.size();
      for (int n = 0; n < 3; ++n) bytes[random() % reach] = static_cast<char>(random());
      ++outcomes[refusal(bytes).empty()];
    }
  }
  EXPECT_GT(outcomes[true], 20);
  EXPECT_GT(outcomes[false], 60);
}

TEST(ImageProbe, WithstandsRandomBytes) {
  std::mt19937 random(5);
  const std::vector<std::string> begins{
      "\x89PNG\r\n\x1a\n", "\xff\xd8\xff", "BM", "II*\0"s, "MM\0*"s, "II+\0"s, "P5 ", "P1 "};
  for (int i = 0; i < 20000; ++i) {
    std::string bytes = begins[static_cast<std::size_t>(i) % begins.size()];
    for (unsigned n = static_cast<unsigned>(random() % 200); n > 0; --n)
      bytes += static_cast<char>(random() % 3 == 0 ? 0 : random());
    try {
      const ImageProbe probe = probe_image(std::as_bytes(std::span(bytes)));
      EXPECT_GE(probe.width, 1);
      EXPECT_GE(probe.height, 1);
    } catch (const IoError&) {
    }
  }
}

TEST(ImageEnding, IsToldWithoutRegardToCase) {
  for (const auto* name :
       {"a.png", "A.PNG", "b.Tif", "c.tiff", "x.y.bmp", "d.jpg", "d.jpeg", "e.pgm", "e.pnm", "f.ppm"})
    EXPECT_TRUE(has_image_ending(name)) << name;
  for (const auto* name : {"a", "png", "a.pn", "a.png2", "a.png ", "a.txt", "a.", "", ".", "a.y4m"})
    EXPECT_FALSE(has_image_ending(name)) << name;
}

}  // namespace
}  // namespace vsfind
