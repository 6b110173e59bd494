#pragma once
/// @file
/// A folder of images as a source.

#include <memory>
#include <string>

#include "acquisition/source.h"

namespace vsfind {

/// The images of a folder in name order (the bytes of the names compared, so frame10.png comes before frame9.png:
/// number with leading zeros). Files with other endings, hidden files and folders within are ignored. The sequence
/// counts the images from 0; there is no timestamp (Clock::none); the field order is unknown. Width, height and bits
/// of the info are those of the first image; the others may differ. A damaged image comes as an empty frame of status
/// corrupt, and the log names it once. Throws IoError in one line where the folder cannot be read or holds no image.
[[nodiscard]] std::unique_ptr<FrameSource> open_image_folder(const std::string& path);

}  // namespace vsfind
