#include "dump.h"

#include <fmt/core.h>

#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "acquisition/errors.h"

namespace vsfind::measure {
namespace {

void outline(cv::Mat& picture, const Mapping& mapping, const Pattern& pattern, const Pose& pose,
             const cv::Scalar& colour) {
  const double left = pattern.left * pattern.pitch;
  const double top = pattern.top * pattern.pitch;
  const double right = left + pattern.width * pattern.pitch;
  const double bottom = top + pattern.height * pattern.pitch;
  std::vector<cv::Point> corners;
  for (const Eigen::Vector2d& corner : {Eigen::Vector2d(left, top), Eigen::Vector2d(right, top),
                                        Eigen::Vector2d(right, bottom), Eigen::Vector2d(left, bottom)}) {
    const Eigen::Vector2d p = mapping.image_from_plane(plane_from_pattern(pose, corner)) * 16.0;
    corners.emplace_back(static_cast<int>(p.x()), static_cast<int>(p.y()));
  }
  cv::polylines(picture, corners, true, colour, 1, cv::LINE_AA, 4);
}

}  // namespace

void dump(const std::string& folder, std::string name, const Shot& shot, const Pattern& pattern,
          const std::vector<Match>& matches) {
  const ImageView view = shot.picture.view();
  cv::Mat grey(view.height, view.width, CV_8UC1);
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x)
      grey.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(view.at(x, y) >> (view.bits - 8));
  }
  cv::Mat picture;
  cv::cvtColor(grey, picture, cv::COLOR_GRAY2BGR);
  for (const Pose& truth : shot.truth) outline(picture, shot.mapping, pattern, truth, {0, 200, 0});
  int line = 14;
  for (const Match& match : matches) {
    outline(picture, shot.mapping, pattern, match.pose, {0, 0, 255});
    const std::string text =
        fmt::format("{:.3f} visible {:.2f}: {:.2f} {:.2f} {:.2f} deg {:.3f} {:.3f}", match.score, match.visible,
                    match.pose.x, match.pose.y, match.pose.angle_deg, match.pose.scale_x, match.pose.scale_y);
    cv::putText(picture, text, {4, line}, cv::FONT_HERSHEY_SIMPLEX, 0.42, {0, 0, 255}, 1, cv::LINE_AA);
    line += 16;
  }
  for (char& c : name) {
    if (c == ' ' || c == '/') c = '_';
  }
  std::filesystem::create_directories(folder);
  const std::string file = folder + '/' + name + ".png";
  if (!cv::imwrite(file, picture)) throw IoError(fmt::format("{}: cannot be written", file));
}

}  // namespace vsfind::measure
