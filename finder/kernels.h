#pragma once
/// @file
/// The inner loops of the search on 8-bit pictures, compiled for several instruction sets and chosen at run time.
/// Everything is integer arithmetic: each target gives the bits of its scalar twin in `namespace scalar`.

#include <cstddef>
#include <cstdint>

#include "finder/pose.h"

namespace vsfind::kernels {

/// Positions that best_dots() handles at a time.
inline constexpr int dot_block = 32;
/// Most that the weights of best_dots() may sum to, signs left out: 7-bit pixels times these fit 16 bits.
inline constexpr int most_weight = 32767 / 127;
/// Bytes that a kernel may read beyond the last pixel that it needs.
inline constexpr int read_slack = 64;

/// Halves a row pair both ways: out[i] = mean of a[2i], a[2i+1], b[2i], b[2i+1], rounded; `count` outputs.
void halve_both(const std::uint8_t* a, const std::uint8_t* b, std::uint8_t* out, int count);
/// Halves a row along x: out[i] = mean of a[2i], a[2i+1], rounded.
void halve_x(const std::uint8_t* a, std::uint8_t* out, int count);
/// Halves a row pair along y: out[i] = mean of a[i], b[i], rounded.
void halve_y(const std::uint8_t* a, const std::uint8_t* b, std::uint8_t* out, int count);

/// Sparse correlation for `count` neighbouring positions, count rounded up to dot_block, of a plane of 7-bit pixels
/// (0 … 127). With dot[p] = Σ weights[i]·base[p + offsets[i]] over i < points, an even number, and score[p] = dot[p] ·
/// factor[p] / 65536 rounded down, its sign turned as `polarity` says: where that is more than best[p], best[p] becomes
/// it and which[p] becomes `id`.
void best_dots(const std::uint8_t* base, const std::ptrdiff_t* offsets, const std::int8_t* weights, int points,
               int count, Polarity polarity, const std::int16_t* factor, std::uint16_t id, std::int16_t* best,
               std::uint16_t* which);

/// Of a row of scores, those that are at least `least` and higher than their eight neighbours (of equal ones the last
/// one in reading order): their columns, at most `count`, into `columns`; returns how many. Reads an entry beyond the
/// row on either side, and the rows above and below it.
int local_maxima(const std::int16_t* above, const std::int16_t* row, const std::int16_t* below, int count,
                 std::int16_t least, std::uint16_t* columns);

/// Points of a sparse correlation about one position; all arrays are padded to a multiple of sum_block, weights with 0.
struct SparsePoints {
  const std::ptrdiff_t* offsets = nullptr;  ///< in the plane
  const std::int16_t* du = nullptr;         ///< the same in pixels, along x and y
  const std::int16_t* dv = nullptr;
  const std::int16_t* weights = nullptr;
  int count = 0;  ///< at most most_sum_points
};
/// What a correlation is made of.
struct SparseSums {
  std::int32_t count = 0;           ///< of the points inside
  std::int32_t pixels = 0;          ///< Σ p
  std::int32_t squares = 0;         ///< Σ p²
  std::int32_t dots = 0;            ///< Σ p·weight
  std::int32_t weights = 0;         ///< Σ weight
  std::int32_t weight_squares = 0;  ///< Σ weight²
};
/// The sums over the points for which least_u <= du <= most_u and least_v <= dv <= most_v, p = base[offset] of 7 bits.
/// The plane must be there for all of them.
[[nodiscard]] SparseSums sums_inside(const std::uint8_t* base, const SparsePoints& points, int least_u, int most_u,
                                     int least_v, int most_v);
inline constexpr int sum_block = 32;
inline constexpr int most_sum_points = 128;

/// The least and the largest pixel of a picture that is not empty, rows `stride` bytes apart.
void range_of(const std::uint8_t* from, std::ptrdiff_t stride, int width, int height, std::uint8_t& least,
              std::uint8_t& most);

/// to[i] = (from[i] − least) · factor >> 8; the product must fit 16 bits.
void stretch(const std::uint8_t* from, int count, std::uint8_t least, std::uint16_t factor, std::uint8_t* to);

/// The name of the instruction set in use, for the log.
[[nodiscard]] const char* target_name();

namespace scalar {
void halve_both(const std::uint8_t* a, const std::uint8_t* b, std::uint8_t* out, int count);
void halve_x(const std::uint8_t* a, std::uint8_t* out, int count);
void halve_y(const std::uint8_t* a, const std::uint8_t* b, std::uint8_t* out, int count);
void best_dots(const std::uint8_t* base, const std::ptrdiff_t* offsets, const std::int8_t* weights, int points,
               int count, Polarity polarity, const std::int16_t* factor, std::uint16_t id, std::int16_t* best,
               std::uint16_t* which);
int local_maxima(const std::int16_t* above, const std::int16_t* row, const std::int16_t* below, int count,
                 std::int16_t least, std::uint16_t* columns);
[[nodiscard]] SparseSums sums_inside(const std::uint8_t* base, const SparsePoints& points, int least_u, int most_u,
                                     int least_v, int most_v);
void range_of(const std::uint8_t* from, std::ptrdiff_t stride, int width, int height, std::uint8_t& least,
              std::uint8_t& most);
void stretch(const std::uint8_t* from, int count, std::uint8_t least, std::uint16_t factor, std::uint8_t* to);
}  // namespace scalar

}  // namespace vsfind::kernels
