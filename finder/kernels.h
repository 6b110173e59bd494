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
/// (0 … 127). With dot[p] = Σ weights[i]·base[p + offsets[i]] over i < points, an even number, and score[p] = dot[p] /
/// 4 rounded down, its sign turned as `polarity` says: where that is more than best[p], best[p] becomes it and which[p]
/// becomes `id`.
void best_dots(const std::uint8_t* base, const std::ptrdiff_t* offsets, const std::int8_t* weights, int points,
               int count, Polarity polarity, std::uint16_t id, std::int16_t* best, std::uint16_t* which);

/// The same where points may lie outside the picture, the plane being 0 there. With sum[p] = Σ base[p + offsets[i]]
/// (at most most_sum_points of them), score[p] = (dot[p]·factor[p] >> 16) − (4·sum[p]·shift[p] >> 16).
void best_dots_inside(const std::uint8_t* base, const std::ptrdiff_t* offsets, const std::int8_t* weights, int points,
                      int count, Polarity polarity, const std::int16_t* factor, const std::int16_t* shift,
                      std::uint16_t id, std::int16_t* best, std::uint16_t* which);
inline constexpr int most_sum_points = 64;

/// The name of the instruction set in use, for the log.
[[nodiscard]] const char* target_name();

namespace scalar {
void halve_both(const std::uint8_t* a, const std::uint8_t* b, std::uint8_t* out, int count);
void halve_x(const std::uint8_t* a, std::uint8_t* out, int count);
void halve_y(const std::uint8_t* a, const std::uint8_t* b, std::uint8_t* out, int count);
void best_dots(const std::uint8_t* base, const std::ptrdiff_t* offsets, const std::int8_t* weights, int points,
               int count, Polarity polarity, std::uint16_t id, std::int16_t* best, std::uint16_t* which);
void best_dots_inside(const std::uint8_t* base, const std::ptrdiff_t* offsets, const std::int8_t* weights, int points,
                      int count, Polarity polarity, const std::int16_t* factor, const std::int16_t* shift,
                      std::uint16_t id, std::int16_t* best, std::uint16_t* which);
}  // namespace scalar

}  // namespace vsfind::kernels
