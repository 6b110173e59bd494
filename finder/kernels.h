#pragma once
/// @file
/// The inner loops of the search on 8-bit pictures, compiled for several instruction sets and chosen at run time.
/// Everything is integer arithmetic: each target gives the bits of its scalar twin in `namespace scalar`.

#include <cstddef>
#include <cstdint>

namespace vsfind::kernels {

/// Most points of one correlation: the sums below cannot overflow then.
inline constexpr int max_points = 128;
/// Bytes that a kernel may read beyond the last pixel that it needs.
inline constexpr int read_slack = 64;

/// Halves a row pair both ways: out[i] = mean of a[2i], a[2i+1], b[2i], b[2i+1], rounded; `count` outputs.
void halve_both(const std::uint8_t* a, const std::uint8_t* b, std::uint8_t* out, int count);
/// Halves a row along x: out[i] = mean of a[2i], a[2i+1], rounded.
void halve_x(const std::uint8_t* a, std::uint8_t* out, int count);
/// Halves a row pair along y: out[i] = mean of a[i], b[i], rounded.
void halve_y(const std::uint8_t* a, const std::uint8_t* b, std::uint8_t* out, int count);

/// Sparse correlation for `count` neighbouring positions. With v(i,p) = base[p + offsets[i]] − 128:
///   sum[p] = Σ v,  square[p] = Σ v²,  dot[p] = Σ weights[i]·v      over i < points, |weights| <= 127.
/// `points` is even and at most max_points. The outputs need room for `count` rounded up to a multiple of 32.
void correlate_row(const std::uint8_t* base, const std::ptrdiff_t* offsets, const std::int16_t* weights, int points,
                   int count, std::int32_t* sum, std::int32_t* square, std::int32_t* dot);

/// The name of the instruction set in use, for the log.
[[nodiscard]] const char* target_name();

namespace scalar {
void halve_both(const std::uint8_t* a, const std::uint8_t* b, std::uint8_t* out, int count);
void halve_x(const std::uint8_t* a, std::uint8_t* out, int count);
void halve_y(const std::uint8_t* a, const std::uint8_t* b, std::uint8_t* out, int count);
void correlate_row(const std::uint8_t* base, const std::ptrdiff_t* offsets, const std::int16_t* weights, int points,
                   int count, std::int32_t* sum, std::int32_t* square, std::int32_t* dot);
}  // namespace scalar

}  // namespace vsfind::kernels
