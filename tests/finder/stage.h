#pragma once
/// @file
/// The rendered scenes on which the finder is measured, with the poses that it must answer.

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "app/render/clutter.h"
#include "app/render/patterns.h"
#include "app/render/sensor.h"
#include "app/render/truth.h"
#include "finder/search.h"
#include "finder/train.h"
#include "measured.h"

namespace vsfind::measure {

enum class Kind { bullseye, artwork, small_artwork };
[[nodiscard]] const char* name(Kind kind);
[[nodiscard]] render::Drawing drawing_of(Kind kind);

/// How a pattern is trained for a row.
struct Training {
  Kind kind = Kind::bullseye;
  Range angle{-45.0, 45.0};
  Range scale{1.0, 1.0};  ///< of x and y independently
  int accuracy = 30;
  bool edges = false;
  Polarity polarity = Polarity::same;
  double noise = 2.0;
  std::uint64_t seed = 1;
  double size = 1.0;  ///< pattern and picture so many times as large
};

/// A trained pattern and where it was when it was trained.
struct Trained {
  std::shared_ptr<const Pattern> pattern;
  render::Drawing drawing;
  Pose pose;
  Eigen::Vector2d origin;
  Training training;
};

/// Renders the training picture (the paper's target sheet with the drawing off the pixel grid in its middle) and
/// trains.
[[nodiscard]] Trained train_on(const Training& training);

/// What is in a scene, and how it is taken.
struct Recipe {
  int instances = 1;
  double angle_limit = 43.0;  ///< degrees to either side
  Range scale{1.0, 1.0};
  int clutter = 25;
  double decoys = 0.1;
  bool quiet_zone = true;  ///< background around the pattern; else clutter touches it
  double hidden = 0.0;
  double outside = 0.0;
  bool remap = false;
  /// Grey level; 200 is that of the training picture. Another one changes the pattern itself where its box is wider
  /// than its outline.
  Range background{200.0, 200.0};
  double blur = 0.7;
  render::Sensor sensor;
  bool random_shading = false;  ///< strong, of random direction
  Field field = Field::frame;   ///< which lines are taken
};

struct Shot {
  render::Picture picture;
  Mapping mapping;
  std::vector<Pose> truth;  ///< what the finder must answer
};

/// A scene at random, all of it given by the seed.
[[nodiscard]] Shot random_shot(const Trained& trained, const Recipe& recipe, std::uint64_t seed);

/// The target sheet with the pattern at the given place.
[[nodiscard]] Shot sheet_shot(const Trained& trained, const Pose& scene_pose, double blur, const render::Sensor& sensor,
                              Field field = Field::frame);

/// Where pictures of failures go; empty: nowhere.
extern std::string dump_folder;

/// Searches the shot, files the errors in the row. A match is right within 0.5 px and 0.3 degrees of the truth; every
/// match beyond the expected ones counts as a failure. Returns the matches of the first pattern.
const std::vector<Match>& judge(Finder& finder, const Trained& trained, const Shot& shot, Row& row, std::uint64_t seed);

/// One finder for one pattern.
[[nodiscard]] Finder finder_for(const Trained& trained, const SearchOptions& options);

}  // namespace vsfind::measure
