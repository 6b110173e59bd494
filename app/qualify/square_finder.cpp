#include "app/qualify/square_finder.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "app/frame_searcher.h"

namespace vsfind {
namespace {

constexpr double shortest_side = 10.0;  // pixels
constexpr std::size_t most_squares = 64;

Eigen::Vector2d mean_of(const std::array<Eigen::Vector2d, 4>& corners) {
  return (corners[0] + corners[1] + corners[2] + corners[3]) / 4.0;
}

/// The contour's four corners as a square on the plane, if it is one.
bool as_square(const std::vector<cv::Point>& corners, const Roi& where, const Mapping& mapping, RoughSquare& square) {
  if (corners.size() != 4 || !cv::isContourConvex(corners)) return false;
  std::array<Eigen::Vector2d, 4> plane;
  for (std::size_t i = 0; i < 4; ++i) {
    // What touches the border may go on beyond it.
    if (corners[i].x <= 1 || corners[i].y <= 1 || corners[i].x >= where.width - 2 || corners[i].y >= where.height - 2) {
      return false;
    }
    square.corners[i] = Eigen::Vector2d(corners[i].x + where.x, corners[i].y + where.y);
    plane[i] = mapping.plane_from_image(square.corners[i]);
    if (!plane[i].allFinite()) return false;
  }
  double shortest = 1e300;
  double longest = 0.0;
  double sum = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    if ((square.corners[(i + 1) % 4] - square.corners[i]).norm() < shortest_side / 2.0) return false;
    const double side = (plane[(i + 1) % 4] - plane[i]).norm();
    shortest = std::min(shortest, side);
    longest = std::max(longest, side);
    sum += side;
  }
  const double diagonals = (plane[2] - plane[0]).norm() / std::max(1e-300, (plane[3] - plane[1]).norm());
  if (shortest < longest / 1.2 || diagonals < 1.0 / 1.15 || diagonals > 1.15) return false;
  square.side = sum / 4.0;
  square.centre = mean_of(square.corners);
  return true;
}

bool same_square(const RoughSquare& a, const RoughSquare& b, double pixels_per_unit) {
  return (a.centre - b.centre).norm() < 0.2 * a.side * pixels_per_unit && std::abs(a.side - b.side) < 0.15 * a.side;
}

Eigen::Vector2d centre_of_four(const std::array<const RoughSquare*, 4>& four) {
  return (four[0]->centre + four[1]->centre + four[2]->centre + four[3]->centre) / 4.0;
}

/// Sorts round their middle as seen, from the top left, and tells the area of the quadrilateral; 0 where the place is
/// not inside.
double area_around(std::array<const RoughSquare*, 4>& four, const Eigen::Vector2d& place) {
  const Eigen::Vector2d middle = centre_of_four(four);
  const auto turn = [&](const RoughSquare* s) {
    return std::atan2(s->centre.y() - middle.y(), s->centre.x() - middle.x());
  };
  std::sort(four.begin(), four.end(), [&](const auto* a, const auto* b) { return turn(a) < turn(b); });
  double area = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d& a = four[i]->centre;
    const Eigen::Vector2d& b = four[(i + 1) % 4]->centre;
    const Eigen::Vector2d& c = four[(i + 2) % 4]->centre;
    const auto cross = [](const Eigen::Vector2d& p, const Eigen::Vector2d& q) { return p.x() * q.y() - p.y() * q.x(); };
    if (cross(b - a, place - a) <= 0.0 || cross(b - a, c - b) <= 0.0) return 0.0;
    area += 0.5 * cross(a, b);
  }
  return area;
}

}  // namespace

std::vector<RoughSquare> find_squares(const ImageView& image, const Mapping& mapping, const Roi& where) {
  if (image.empty()) return {};
  Roi roi;
  roi.x = std::clamp(where.x, 0, image.width);
  roi.y = std::clamp(where.y, 0, image.height);
  roi.width = std::clamp(where.x + where.width, 0, image.width) - roi.x;
  roi.height = std::clamp(where.y + where.height, 0, image.height) - roi.y;
  if (roi.width < 8 || roi.height < 8) return {};
  ImageView part = image;
  part.data += roi.y * image.stride + static_cast<std::ptrdiff_t>(roi.x) * image.bytes_per_pixel();
  part.width = roi.width;
  part.height = roi.height;
  GreyPicture grey = grey_picture(part);
  const cv::Mat pixels(grey.height, grey.width, CV_8UC1, grey.pixels.data());
  cv::Mat smooth;
  cv::GaussianBlur(pixels, smooth, {3, 3}, 0.0);
  cv::Mat mask;
  cv::threshold(smooth, mask, 0, 255, cv::THRESH_BINARY | cv::THRESH_OTSU);
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(mask, contours, cv::RETR_LIST, cv::CHAIN_APPROX_NONE);

  std::vector<RoughSquare> squares;
  for (const auto& contour : contours) {
    if (static_cast<double>(contour.size()) < 2.0 * shortest_side) continue;
    std::vector<cv::Point> corners;
    cv::approxPolyDP(contour, corners, 0.06 * cv::arcLength(contour, true), true);
    RoughSquare square;
    if (as_square(corners, roi, mapping, square)) squares.push_back(square);
  }
  std::sort(squares.begin(), squares.end(), [](const auto& a, const auto& b) { return a.side > b.side; });
  std::vector<RoughSquare> once;
  for (const auto& square : squares) {
    const double pixels_per_unit = (square.corners[1] - square.corners[0]).norm() / square.side;
    const bool known = std::any_of(once.begin(), once.end(),
                                   [&](const auto& other) { return same_square(other, square, pixels_per_unit); });
    if (!known) once.push_back(square);
    if (once.size() == most_squares) break;
  }
  return once;
}

std::vector<RoughSquare> four_around(const std::vector<RoughSquare>& squares, const Eigen::Vector2d& place,
                                     double clear) {
  std::vector<const RoughSquare*> candidates;
  for (const auto& square : squares) {
    if ((square.centre - place).norm() > clear) candidates.push_back(&square);
  }
  constexpr std::size_t most = 24;  // 10626 sets of four
  if (candidates.size() > most) candidates.resize(most);
  std::array<const RoughSquare*, 4> best{};
  double best_area = 0.0;
  const std::size_t n = candidates.size();
  for (std::size_t a = 0; a + 3 < n; ++a) {
    for (std::size_t b = a + 1; b + 2 < n; ++b) {
      for (std::size_t c = b + 1; c + 1 < n; ++c) {
        for (std::size_t d = c + 1; d < n; ++d) {
          if (candidates[d]->side < candidates[a]->side / 1.15) break;  // they are in the order of size
          std::array<const RoughSquare*, 4> four{candidates[a], candidates[b], candidates[c], candidates[d]};
          const double area = area_around(four, place);
          if (area > best_area) {
            best_area = area;
            best = four;
          }
        }
      }
    }
  }
  std::vector<RoughSquare> chosen;
  if (best_area > 0.0) {
    for (const auto* square : best) chosen.push_back(*square);
  }
  return chosen;
}

}  // namespace vsfind
