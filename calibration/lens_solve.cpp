#include "calibration/lens_solve.h"

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "acquisition/errors.h"
#include "calibration/rotation.h"

namespace vsfind {
namespace {

int flags_for(int distortion) {
  int flags = 0;
  if (distortion < 2) flags |= cv::CALIB_FIX_K1 | cv::CALIB_FIX_K2;
  if (distortion < 4) flags |= cv::CALIB_ZERO_TANGENT_DIST;
  if (distortion < 5) flags |= cv::CALIB_FIX_K3;
  if (distortion >= 8) flags |= cv::CALIB_RATIONAL_MODEL;
  return flags;
}

}  // namespace

SolvedLens solve_lens(const std::vector<BoardView>& views, const SolveOptions& options) {
  std::vector<std::vector<cv::Point3f>> board;
  std::vector<std::vector<cv::Point2f>> image;
  for (const BoardView& view : views) {
    auto& object = board.emplace_back();
    auto& frame = image.emplace_back();
    for (const auto& p : view.board) object.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()), 0.0F);
    for (const auto& p : view.frame) frame.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  }
  cv::Mat camera = cv::Mat::eye(3, 3, CV_64F);
  cv::Mat coefficients = cv::Mat::zeros(options.distortion >= 8 ? 8 : 5, 1, CV_64F);
  cv::Mat deviations, pose_deviations, view_errors;
  std::vector<cv::Mat> rotations, translations;
  try {
    cv::calibrateCamera(board, image, cv::Size(options.image_width, options.image_height), camera, coefficients,
                        rotations, translations, deviations, pose_deviations, view_errors,
                        flags_for(options.distortion),
                        cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 300, 1e-12));
  } catch (const cv::Exception&) {
    throw UsageError("the views do not determine the lens: the equations have no solution");
  }
  const auto number = [](const cv::Mat& m, int i) { return m.at<double>(i); };
  SolvedLens solved;
  std::vector<double> k(coefficients.begin<double>(), coefficients.end<double>());
  k.resize(options.distortion >= 8 ? 8 : options.distortion == 5 ? 5 : options.distortion == 0 ? 0 : 4);
  try {
    solved.lens =
        Lens(LensModel::polynomial,
             {camera.at<double>(0, 0), camera.at<double>(1, 1), camera.at<double>(0, 2), camera.at<double>(1, 2)}, k);
  } catch (const UsageError&) {
    throw UsageError("the views do not determine the lens: no sensible focal length fits them");
  }
  for (std::size_t i = 0; i < views.size(); ++i) {
    PlanePose pose;
    pose.rotation = rotation_from_vector({number(rotations[i], 0), number(rotations[i], 1), number(rotations[i], 2)});
    pose.translation = {number(translations[i], 0), number(translations[i], 1), number(translations[i], 2)};
    solved.poses.push_back(pose);
  }
  solved.uncertainty = {number(deviations, 0), number(deviations, 1), number(deviations, 2), number(deviations, 3), {}};
  for (std::size_t i = 0; i < k.size(); ++i) {
    solved.uncertainty.coefficients.push_back(number(deviations, 4 + static_cast<int>(i)));
  }
  return solved;
}

double covered_part(const std::vector<BoardView>& views, int width, int height) {
  // Outlines on a coarse picture of the image: 1% is close enough.
  const double scale = 256.0 / std::max(width, height);
  cv::Mat canvas =
      cv::Mat::zeros(static_cast<int>(std::ceil(height * scale)), static_cast<int>(std::ceil(width * scale)), CV_8U);
  for (const BoardView& view : views) {
    std::vector<cv::Point2f> points;
    for (const auto& p : view.frame) {
      points.emplace_back(static_cast<float>((p.x() + 0.5) * scale - 0.5),
                          static_cast<float>((p.y() + 0.5) * scale - 0.5));
    }
    std::vector<cv::Point2f> hull;
    cv::convexHull(points, hull);
    std::vector<cv::Point> corners(hull.begin(), hull.end());
    cv::fillConvexPoly(canvas, corners, cv::Scalar(255));
  }
  return static_cast<double>(cv::countNonZero(canvas)) / static_cast<double>(canvas.total());
}

}  // namespace vsfind
