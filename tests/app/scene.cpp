#include "tests/app/scene.h"

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace vsfind::test {
namespace {

// Threads that OpenCV starts before a test watches signals would take them, and end the process.
[[maybe_unused]] const bool one_thread = (cv::setNumThreads(1), true);

/// Blocks of random grey, smoothed: structure in every direction, and like nothing else in the scene.
cv::Mat part() {
  cv::Mat blocks(10, 10, CV_8UC1);
  cv::RNG random(7);
  random.fill(blocks, cv::RNG::UNIFORM, 20, 235);
  cv::Mat picture;
  cv::resize(blocks, picture, {part_side, part_side}, 0, 0, cv::INTER_NEAREST);
  return picture;
}

}  // namespace

cv::Mat scene_without_part() {
  cv::Mat picture(scene_height, scene_width, CV_8UC1, cv::Scalar(110));
  cv::RNG random(3);
  cv::Mat noise(picture.size(), CV_8UC1);
  random.fill(noise, cv::RNG::UNIFORM, 0, 5);
  picture += noise;
  return picture;
}

cv::Mat scene(int x, int y) {
  cv::Mat picture = scene_without_part();
  part().copyTo(picture(cv::Rect(x, y, part_side, part_side)));
  cv::GaussianBlur(picture, picture, {5, 5}, 0.8);
  return picture;
}

std::string roi_at(int x, int y) {
  return std::to_string(x) + "," + std::to_string(y) + "," + std::to_string(part_side) + "," +
         std::to_string(part_side);
}

void write_y4m(const std::string& path, const std::vector<cv::Mat>& frames, char interlacing,
               const std::string& more_header) {
  std::ofstream file(path, std::ios::binary);
  file << "YUV4MPEG2 W" << frames.at(0).cols << " H" << frames.at(0).rows << " F25:1 I" << interlacing << " Cmono"
       << more_header << "\n";
  for (const auto& frame : frames) {
    file << "FRAME\n";
    for (int y = 0; y < frame.rows; ++y) file.write(frame.ptr<char>(y), frame.cols);
  }
}

TrainedPart::TrainedPart() {
  cv::imwrite(folder_ / "train.png", scene(100, 80));
  training_ = vsfind({"train", folder_ / "train.png", "--roi", roi_at(100, 80), "-o", model()});
}

}  // namespace vsfind::test
