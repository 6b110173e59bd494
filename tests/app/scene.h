#pragma once
/// @file
/// A made-up part on a background, moved by whole pixels: enough to see that the program connects everything. How
/// exactly poses are found is measured elsewhere.

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "tests/app/shell.h"

namespace vsfind::test {

inline constexpr int scene_width = 320;
inline constexpr int scene_height = 240;
inline constexpr int part_side = 80;

/// The part's left upper corner at (x, y); without one the background alone. Even rows (the top field) and odd rows
/// show it at the same place.
[[nodiscard]] cv::Mat scene(int x, int y);
[[nodiscard]] cv::Mat scene_without_part();

/// The ROI of the part in scene(x, y), as an option's value.
[[nodiscard]] std::string roi_at(int x, int y);

/// A mono recording of whole frames, `interlacing` being the letter of its header (p, t, b).
void write_y4m(const std::string& path, const std::vector<cv::Mat>& frames, char interlacing,
               const std::string& more_header = {});

/// A folder with a trained model "part.vsm" of the part as in scene(100, 80).
class TrainedPart {
 public:
  TrainedPart();
  [[nodiscard]] std::string operator/(const std::string& name) const { return folder_ / name; }
  [[nodiscard]] std::string model() const { return folder_ / "part.vsm"; }
  [[nodiscard]] std::string path() const { return folder_.path(); }
  [[nodiscard]] const Outcome& training() const { return training_; }

 private:
  TemporaryFolder folder_;
  Outcome training_;
};

}  // namespace vsfind::test
