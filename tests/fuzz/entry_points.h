#pragma once
/// @file
/// What the fuzzers feed: every parser of bytes from outside, each as a function that takes any bytes at all. The
/// parsers may refuse with UsageError or IoError; anything else that leaves one of these functions is a fault. Each
/// tells whether the bytes were taken. The corpora are fed to the same functions by the ordinary tests.

#include <cstdint>
#include <span>
#include <vector>

namespace vsfind::fuzz {

using Bytes = std::span<const std::uint8_t>;

struct EntryPoint {
  const char* name;  ///< of the folder of its corpus
  bool (*feed)(Bytes);
};

bool feed_y4m(Bytes bytes);          ///< a recording, up to 16 frames
bool feed_image(Bytes bytes);        ///< an image file
bool feed_model(Bytes bytes);        ///< a model; one with a wrong checksum again with the right one, and then searched
bool feed_calibration(Bytes bytes);  ///< a calibration of our own
bool feed_import(Bytes bytes);       ///< ROS, OpenCV, Kalibr
bool feed_points(Bytes bytes);       ///< point pairs as CSV, and the plane through them
bool feed_config(Bytes bytes);       ///< a YAML configuration of `replay` or of `live`
bool feed_truth(Bytes bytes);        ///< truth as CSV

[[nodiscard]] const std::vector<EntryPoint>& entry_points();

}  // namespace vsfind::fuzz
