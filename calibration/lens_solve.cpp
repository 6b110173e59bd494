#include "calibration/lens_solve.h"

#include <algorithm>
#include <cmath>
#include <limits>
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

struct Points {
  std::vector<std::vector<cv::Point3f>> board;
  std::vector<std::vector<cv::Point2f>> frame;
};

struct Attempt {
  cv::Mat camera = cv::Mat::eye(3, 3, CV_64F);
  cv::Mat coefficients;
  cv::Mat deviations;
  std::vector<cv::Mat> rotations;
  std::vector<cv::Mat> translations;
  double rms = std::numeric_limits<double>::infinity();
};

// `focal` 0: begin where OpenCV would.
Attempt attempt(const Points& points, const SolveOptions& options, double focal) {
  Attempt result;
  result.coefficients = cv::Mat::zeros(options.distortion >= 8 ? 8 : 5, 1, CV_64F);
  int flags = flags_for(options.distortion);
  if (focal > 0.0) {
    flags |= cv::CALIB_USE_INTRINSIC_GUESS;
    result.camera.at<double>(0, 0) = result.camera.at<double>(1, 1) = focal;
    result.camera.at<double>(0, 2) = (options.image_width - 1) / 2.0;
    result.camera.at<double>(1, 2) = (options.image_height - 1) / 2.0;
  }
  cv::Mat pose_deviations, view_errors;
  try {
    const double rms = cv::calibrateCamera(
        points.board, points.frame, cv::Size(options.image_width, options.image_height), result.camera,
        result.coefficients, result.rotations, result.translations, result.deviations, pose_deviations, view_errors,
        flags, cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 100, 1e-12));
    const double fx = result.camera.at<double>(0, 0);
    const double fy = result.camera.at<double>(1, 1);
    if (std::isfinite(rms) && fx > 0.0 && fy > 0.0) result.rms = rms;
  } catch (const cv::Exception&) {
    // Equations without a solution: the attempt stays at an infinite residual.
  }
  return result;
}

// Views that hardly tell the focal length send OpenCV's first guess far away, and the search ends in a false minimum
// there.
bool looks_wrong(const Attempt& result, const SolveOptions& options) {
  const double relative = result.camera.at<double>(0, 0) / std::max(options.image_width, options.image_height);
  return !(result.rms < 0.3) || !(relative > 0.4 && relative < 8.0);
}

Attempt best_attempt(const Points& points, const SolveOptions& options) {
  Attempt best = attempt(points, options, 0.0);
  if (!looks_wrong(best, options)) return best;
  for (const double relative : {0.7, 1.5, 4.0}) {
    const Attempt other = attempt(points, options, relative * std::max(options.image_width, options.image_height));
    if (other.rms < best.rms) best = other;
  }
  return best;
}

}  // namespace

SolvedLens solve_lens(const std::vector<BoardView>& views, const SolveOptions& options) {
  Points points;
  for (const BoardView& view : views) {
    auto& board = points.board.emplace_back();
    auto& frame = points.frame.emplace_back();
    for (const auto& p : view.board) board.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()), 0.0F);
    for (const auto& p : view.frame) frame.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  }
  const Attempt best = best_attempt(points, options);
  if (!std::isfinite(best.rms)) {
    throw UsageError("the views do not determine the lens: the equations have no solution");
  }
  SolvedLens solved;
  std::vector<double> k(best.coefficients.begin<double>(), best.coefficients.end<double>());
  k.resize(options.distortion >= 8 ? 8 : options.distortion == 5 ? 5 : options.distortion == 0 ? 0 : 4);
  const cv::Mat& c = best.camera;
  solved.lens =
      Lens(LensModel::polynomial, {c.at<double>(0, 0), c.at<double>(1, 1), c.at<double>(0, 2), c.at<double>(1, 2)}, k);
  const auto vector = [](const cv::Mat& m) {
    return Eigen::Vector3d(m.at<double>(0), m.at<double>(1), m.at<double>(2));
  };
  for (std::size_t i = 0; i < views.size(); ++i) {
    solved.poses.push_back({rotation_from_vector(vector(best.rotations[i])), vector(best.translations[i])});
  }
  const auto deviation = [&best](int i) { return best.deviations.at<double>(i); };
  solved.uncertainty = {deviation(0), deviation(1), deviation(2), deviation(3), {}};
  for (std::size_t i = 0; i < k.size(); ++i) {
    solved.uncertainty.coefficients.push_back(deviation(4 + static_cast<int>(i)));
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
