#include "calibration/board_detect.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/aruco.hpp>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "calibration/plane_fit.h"

namespace vsfind {
namespace {

// Eight bits; of a field every line twice as high, so that the board has its shape.
cv::Mat detection_picture(const ImageView& image, Field field) {
  const cv::Mat lines(image.height, image.width, image.bits > 8 ? CV_16U : CV_8U,
                      const_cast<std::byte*>(image.data),  // NOLINT: only read from
                      static_cast<std::size_t>(image.stride));
  cv::Mat eight;
  lines.convertTo(eight, CV_8U, 255.0 / image.white());
  if (field != Field::frame) cv::resize(eight, eight, cv::Size(image.width, image.height * 2), 0, 0, cv::INTER_LINEAR);
  return eight;
}

// cv::resize puts row r of the field at 2r + 1/2.
Eigen::Vector2d frame_point(const cv::Point2f& p, Field field) {
  return {p.x, field == Field::frame ? p.y : p.y - 0.5 + first_line(field)};
}

DetectedGrid row_by_row(const std::vector<cv::Point2f>& points, Field field, int columns) {
  DetectedGrid grid;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const int index = static_cast<int>(i);
    grid.points.push_back({index % columns, index / columns, frame_point(points[i], field)});
  }
  return grid;
}

DetectedGrid detect_chessboard(const cv::Mat& picture, Field field, const BoardSpec& spec) {
  const cv::Size size(spec.columns, spec.rows);
  std::vector<cv::Point2f> corners;
  bool found = cv::findChessboardCornersSB(
      picture, size, corners, cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_EXHAUSTIVE | cv::CALIB_CB_ACCURACY);
  // The older detector needs less of a white border.
  if (!found) {
    found = cv::findChessboardCorners(
        picture, size, corners, cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK);
  }
  return found ? row_by_row(corners, field, spec.columns) : DetectedGrid{};
}

DetectedGrid detect_circles(const cv::Mat& picture, Field field, const BoardSpec& spec) {
  cv::SimpleBlobDetector::Params params;
  const float cell = static_cast<float>(picture.total()) / static_cast<float>(spec.columns * spec.rows);
  params.minArea = 16.0F;
  params.maxArea = std::max(32.0F, 0.8F * cell);
  params.minDistBetweenBlobs = 4.0F;
  params.filterByConvexity = true;
  params.minConvexity = 0.8F;
  params.filterByInertia = true;
  params.minInertiaRatio = 0.05F;
  params.minRepeatability = 2;
  std::vector<cv::Point2f> centres;
  // Dark circles, then bright ones.
  for (const uchar colour : {uchar{0}, uchar{255}}) {
    params.blobColor = colour;
    const auto detector = cv::SimpleBlobDetector::create(params);
    for (const int flags : {0 + cv::CALIB_CB_SYMMETRIC_GRID, cv::CALIB_CB_SYMMETRIC_GRID | cv::CALIB_CB_CLUSTERING}) {
      if (cv::findCirclesGrid(picture, {spec.columns, spec.rows}, centres, flags, detector)) {
        return row_by_row(centres, field, spec.columns);
      }
    }
  }
  return {};
}

struct Markers {
  cv::Ptr<cv::aruco::Dictionary> dictionary;
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
};

// Keeps the ids that the board has, each once.
void keep_possible(Markers& markers, int count) {
  Markers kept{markers.dictionary, {}, {}};
  for (std::size_t i = 0; i < markers.ids.size(); ++i) {
    const int id = markers.ids[i];
    if (id < 0 || id >= count || std::count(markers.ids.begin(), markers.ids.end(), id) != 1) continue;
    kept.ids.push_back(id);
    kept.corners.push_back(markers.corners[i]);
  }
  markers = kept;
}

// The dictionary is whichever explains most markers; the small ones are the beginnings of these.
Markers detect_markers(const cv::Mat& picture, int count) {
  Markers best;
  for (const auto name :
       {cv::aruco::DICT_4X4_1000, cv::aruco::DICT_5X5_1000, cv::aruco::DICT_6X6_1000, cv::aruco::DICT_7X7_1000,
        cv::aruco::DICT_ARUCO_ORIGINAL, cv::aruco::DICT_APRILTAG_16h5, cv::aruco::DICT_APRILTAG_25h9,
        cv::aruco::DICT_APRILTAG_36h10, cv::aruco::DICT_APRILTAG_36h11}) {
    Markers markers{cv::aruco::getPredefinedDictionary(name), {}, {}};
    cv::aruco::detectMarkers(picture, markers.dictionary, markers.corners, markers.ids);
    keep_possible(markers, std::min(count, markers.dictionary->bytesList.rows));
    if (markers.ids.size() > best.ids.size()) best = markers;
  }
  return best;
}

// Side of the markers over side of the squares: the centres give the plane, and the plane the markers' sides.
double marker_ratio(const Markers& markers, const cv::Ptr<cv::aruco::CharucoBoard>& board) {
  std::vector<Eigen::Vector2d> plane, image;
  for (std::size_t i = 0; i < markers.ids.size(); ++i) {
    cv::Point3f on_board;
    cv::Point2f in_image;
    for (std::size_t c = 0; c < 4; ++c) {
      on_board += 0.25F * board->objPoints[static_cast<std::size_t>(markers.ids[i])][c];
      in_image += 0.25F * markers.corners[i][c];
    }
    plane.emplace_back(on_board.x, on_board.y);
    image.emplace_back(in_image.x, in_image.y);
  }
  const Eigen::Matrix3d plane_from_image = fit_homography(plane, image).inverse();
  const auto lifted = [&plane_from_image](const cv::Point2f& p) -> Eigen::Vector2d {
    return (plane_from_image * Eigen::Vector3d(p.x, p.y, 1.0)).hnormalized();
  };
  std::vector<double> sides;
  for (const auto& corners : markers.corners) {
    for (std::size_t c = 0; c < 4; ++c) sides.push_back((lifted(corners[c]) - lifted(corners[(c + 1) % 4])).norm());
  }
  const auto middle = sides.begin() + static_cast<std::ptrdiff_t>(sides.size() / 2);
  std::nth_element(sides.begin(), middle, sides.end());
  return std::clamp(*middle, 0.2, 0.98);
}

DetectedGrid detect_charuco(const cv::Mat& picture, Field field, const BoardSpec& spec) {
  const Markers markers = detect_markers(picture, spec.columns * spec.rows / 2);
  if (markers.ids.size() < 4) return {};
  const auto board_with = [&](double ratio) {
    return cv::aruco::CharucoBoard::create(spec.columns, spec.rows, 1.0F, static_cast<float>(ratio),
                                           markers.dictionary);
  };
  const double ratio = marker_ratio(markers, board_with(0.5));
  const auto board = board_with(ratio);
  std::vector<cv::Point2f> corners;
  std::vector<int> ids;
  cv::aruco::interpolateCornersCharuco(markers.corners, markers.ids, picture, board, corners, ids);
  if (corners.size() < 6) return {};
  DetectedGrid grid;
  grid.free_part = 1.0 - ratio;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    grid.points.push_back({ids[i] % (spec.columns - 1), ids[i] / (spec.columns - 1), frame_point(corners[i], field)});
  }
  return grid;
}

}  // namespace

int grid_columns(const BoardSpec& spec) { return spec.kind == BoardKind::charuco ? spec.columns - 1 : spec.columns; }
int grid_rows(const BoardSpec& spec) { return spec.kind == BoardKind::charuco ? spec.rows - 1 : spec.rows; }

DetectedGrid detect_grid(const ImageView& image, Field field, const BoardSpec& spec) {
  if (image.empty() || image.width < 16 || image.height < 16) return {};
  const cv::Mat picture = detection_picture(image, field);
  switch (spec.kind) {
    case BoardKind::chessboard:
      return detect_chessboard(picture, field, spec);
    case BoardKind::circles:
      return detect_circles(picture, field, spec);
    case BoardKind::charuco:
      return detect_charuco(picture, field, spec);
  }
  return {};
}

}  // namespace vsfind
