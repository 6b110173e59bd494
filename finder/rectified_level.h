#pragma once
/// @file
/// A coarse level seen straight on: the exhaustive search tries a pattern at every position with one slope of the
/// mapping for all of them, so where perspective or a lens changes the slope over the picture, the (small) level is
/// resampled first into plane coordinates.
///
/// The grid it is resampled to is the plane under the affine map that the mapping is in the middle of the picture: the
/// picture without what changes over it, on pixels evenly enlarged so that they are no more than the level's, as far as
/// reading the level once for each allows.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "calibration/mapping.h"
#include "finder/coarse_search.h"
#include "finder/pose.h"
#include "finder/pyramid.h"

namespace vsfind {

/// Keeps its tables between pictures: they are made once per mapping and size of the level.
class RectifiedLevel {
 public:
  /// Resamples `level`, which `mapping` takes to the plane and whose pixels are smoothed already. False, and nothing is
  /// done, where it does not pay: the points of a pattern that reaches `reach` plane units from its middle are nowhere
  /// further than half a level pixel from where one slope puts them; or where the mapping has no slope in the middle.
  bool update(const Level& level, const Mapping& mapping, double reach);

  /// After an update() that returned true: the picture on the grid; its pixels are the "image" of mapping(). What the
  /// picture does not show, or shows three times smaller than in the middle, has the mean grey value of the rest. Valid
  /// until the next update().
  [[nodiscard]] const Level& level() const { return out_; }
  /// Affine: from the grid's pixels to the plane.
  [[nodiscard]] const Mapping& mapping() const { return tables_[current_].grid_mapping; }
  /// Of each row of level() the pixels that the picture shows.
  [[nodiscard]] const std::vector<ColumnRange>& shown() const { return tables_[current_].shown; }
  /// The grid's pixels that a region of frame pixels covers, all of them and some more; nothing where it covers none
  /// that can be told.
  [[nodiscard]] std::optional<Roi> region(const Roi& frame) const;

 private:
  /// Where a pixel of the grid is read: four neighbours of the level, weights in 1/128 along x and y.
  struct Tap {
    std::int32_t at = -1;  ///< x + y·width of the upper left one; −1: not seen
    std::uint16_t right = 0;
    std::uint16_t below = 0;
  };
  struct Table {
    Mapping mapping;
    int width = 0;  ///< of the level
    int height = 0;
    double step_x = 0.0;
    double step_y = 0.0;
    double scale = 0.0;   ///< level pixels to a plane unit in the middle
    double change = 0.0;  ///< of the slope over the picture, relative to that in the middle: largest singular value
    bool usable = false;
    Mapping grid_mapping;
    int grid_width = 0;
    int grid_height = 0;
    int samples = 1;  ///< along each axis of a pixel of the grid
    std::vector<Tap> taps;
    std::vector<ColumnRange> shown;
  };

  static Table make_table(const Level& level, const Mapping& mapping);
  static void add_taps(const Level& level, Table& table);

  std::vector<Table> tables_;  ///< the newest first: of both fields, say
  std::size_t current_ = 0;
  Level out_;
  std::vector<std::uint8_t> memory_;
};

}  // namespace vsfind
