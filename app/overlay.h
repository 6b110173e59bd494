#pragma once
/// @file
/// Pictures of what was found: the pattern's outline, points and origin drawn at its pose, with score and pose in
/// words.

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "app/frame_searcher.h"

namespace vsfind {

/// The picture in the shape of a whole frame, colour, ready to be drawn on: a field's rows lie at their frame rows
/// (2r of the top field, 2r+1 of the bottom one), the rows between are interpolated.
[[nodiscard]] cv::Mat overlay_canvas(const GreyPicture& grey, Field field);

/// The outline of a pattern that lies at a pose, in frame pixels: a closed line of many points, as a side may be
/// curved.
[[nodiscard]] std::vector<Eigen::Vector2d> pattern_outline(const Pattern& pattern, const Pose& pose,
                                                           const Mapping& frame_mapping);

/// Draws what was found of one picture. `canvas` is in frame pixels, `frame_mapping` takes them to the plane.
void draw_matches(cv::Mat& canvas, const PictureResult& picture,
                  const std::vector<std::shared_ptr<const Pattern>>& patterns, const Mapping& frame_mapping);

/// "s0-00000012-frame.png", "s0-00000012-a-top.png": names that sort by source, frame, and order of exposure (a, b).
[[nodiscard]] std::string overlay_name(std::size_t source_index, std::uint64_t frame, Field field,
                                       std::size_t index_in_frame);

class OverlayWriter {
 public:
  /// Makes the folder where there is none. Throws IoError where that or writing into it fails.
  explicit OverlayWriter(std::string folder);
  /// Writes one PNG per searched picture. Throws IoError.
  void write(const FrameResult& result, const std::vector<std::shared_ptr<const Pattern>>& patterns,
             const Mapping& frame_mapping) const;

 private:
  std::string folder_;
};

}  // namespace vsfind
