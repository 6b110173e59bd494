#pragma once
/// @file
/// A trained pattern as a picture: enlarged, with its points.

#include <opencv2/core.hpp>
#include <string>

#include "finder/pattern.h"

namespace vsfind {

/// The pattern's own picture enlarged by a whole number, twice. Left the coarse points as black x with a white rim, the
/// points of the sub-pixel pose as white + with a black rim, those of the outermost edges as yellow +, and the origin;
/// right the points that follow candidates down, squares in a colour for each level, and those of the score; a legend
/// in words below. What is not part of the pattern is darkened. `zoom` is given back where it is wanted.
[[nodiscard]] cv::Mat model_picture(const Pattern& pattern, int* zoom = nullptr);

/// Writes it as PNG. Throws IoError; UsageError where the model holds no picture.
void write_model_picture(const Pattern& pattern, const std::string& path);

}  // namespace vsfind
