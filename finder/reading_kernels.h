#pragma once
/// @file
/// A picture read at points, in single precision; compiled for several instruction sets and chosen at run time. Each
/// has its scalar twin in `namespace scalar`; they agree within rounding (sums are added in another order).
///
/// Arrays of points as in point_block.h.

#include <cstddef>
#include <cstdint>

#include "finder/point_block.h"

namespace vsfind::kernels {

/// A picture read around one of its pixels, which is (0,0) of the coordinates here: single precision holds a
/// thousandth of a pixel only near zero.
struct ReadPlane {
  const std::byte* base = nullptr;  ///< that pixel; need not lie inside the picture
  std::ptrdiff_t stride = 0;        ///< bytes from row to row
  float left = 0.0F;                ///< of the picture's first column and row
  float top = 0.0F;
  float right = 0.0F;  ///< of the last ones
  float bottom = 0.0F;
};

/// (u, v) = (m[0]·x + m[1]·y + m[2], m[3]·x + m[4]·y + m[5]).
void project(const float* x, const float* y, int count, const float m[6], float* u, float* v);

/// Reads an 8-bit plane, bilinearly. Where a point is outside (or NaN), out and inside are 0, else inside is 1.
void read_bilinear(const ReadPlane& plane, const float* u, const float* v, int count, float* out, float* inside);

/// Reads an 8-bit plane as if it were smoothed by [1 2 1]/4 both ways and then read bilinearly: 4 × 4 taps. Needs a
/// pixel more around the point than read_bilinear.
void read_smoothed(const ReadPlane& plane, const float* u, const float* v, int count, float* out, float* inside);

/// Reads through a Gaussian: 8 × 8 taps with weights exp(kx·dx² + ky·dy²), normalized; times `scale`. Pixels of 1 or 2
/// bytes.
void read_gaussian(const ReadPlane& plane, int pixel_bytes, float kx, float ky, float scale, const float* u,
                   const float* v, int count, float* out, float* inside);

namespace scalar {
void project(const float* x, const float* y, int count, const float m[6], float* u, float* v);
void read_bilinear(const ReadPlane& plane, const float* u, const float* v, int count, float* out, float* inside);
void read_smoothed(const ReadPlane& plane, const float* u, const float* v, int count, float* out, float* inside);
void read_gaussian(const ReadPlane& plane, int pixel_bytes, float kx, float ky, float scale, const float* u,
                   const float* v, int count, float* out, float* inside);
}  // namespace scalar

}  // namespace vsfind::kernels
