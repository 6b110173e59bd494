#pragma once
/// @file
/// A calibration for the eyes: what was detected, where the calibration puts it, and the plane's grid over the image.

#include <opencv2/core.hpp>
#include <string>

#include "acquisition/image_view.h"
#include "calibration/board.h"
#include "calibration/calibration.h"

namespace vsfind {

/// Draws over the picture (an empty one: over plain grey of the frame's size), enlarged where it is small: the plane's
/// grid with its axes, each detected point as a green ring, and from it an orange line to where the calibration puts
/// it, magnified. The legend says by how much. `view` is of the plane that the calibration describes.
[[nodiscard]] cv::Mat calibration_picture(const ImageView& image, Field field, const Calibration& calibration,
                                          const BoardView& view);

}  // namespace vsfind
