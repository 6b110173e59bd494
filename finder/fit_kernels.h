#pragma once
/// @file
/// The inner loops of the pose fit in single precision, compiled for several instruction sets and chosen at run time.
/// Each has its scalar twin in `namespace scalar`; they agree within rounding (sums are added in another order).
///
/// All arrays of points have room for `count` rounded up to a multiple of `fit_block`, and are computed that far.

#include <cstddef>
#include <cstdint>

namespace vsfind::kernels {

inline constexpr int fit_block = 8;
[[nodiscard]] constexpr int padded(int count) { return (count + fit_block - 1) / fit_block * fit_block; }

/// Most columns of normal_equations(), the target among them.
inline constexpr int most_columns = 15;

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

/// residual = value − Σ columns[r]·beta[r].
void residuals(const float* const* columns, const float* beta, int number, const float* value, int count,
               float* residual);

/// weight = inside · max(0, 1 − (residual·inverse_cut)²)² (Tukey's biweight).
void tukey_weights(const float* residual, const float* inside, float inverse_cut, int count, float* weight);

/// lower[r·(r+1)/2 + s] = Σ weight·columns[r]·columns[s], s <= r < number <= most_columns.
void normal_equations(const float* const* columns, int number, const float* weight, int count, double* lower);

/// sums = Σ inside·{1, value, target, value², target², value·target}.
void correlation_sums(const float* value, const float* target, const float* inside, int count, double sums[6]);

/// Σ inside · max(0, 1 − ((value − gain·target − offset)·inverse_cut)²).
float agreement(const float* value, const float* target, const float* inside, int count, float gain, float offset,
                float inverse_cut);

/// The median (of an even number, the upper one) of the |residual| below `limit` of the points inside; negative where
/// there are none. Equal to its twin bit for bit. `scratch`: room for as many numbers as there are points, rounded up.
float median_below(const float* residual, const float* inside, float limit, int count, float* scratch);

/// What judges a view, over the points inside: how many there are, how many have |residual| <= visible_within; then
/// with w = max(0, 1 − (residual·inverse_cut)²)²: sums = Σ {w, w·target², w·residual², w·value, w·value²}.
struct ViewSums {
  int inside = 0;
  int seen = 0;
  double sums[5] = {0.0, 0.0, 0.0, 0.0, 0.0};
};
ViewSums view_sums(const float* residual, const float* target, const float* value, const float* inside, int count,
                   float inverse_cut, float visible_within);

namespace scalar {
void project(const float* x, const float* y, int count, const float m[6], float* u, float* v);
void read_bilinear(const ReadPlane& plane, const float* u, const float* v, int count, float* out, float* inside);
void read_smoothed(const ReadPlane& plane, const float* u, const float* v, int count, float* out, float* inside);
void read_gaussian(const ReadPlane& plane, int pixel_bytes, float kx, float ky, float scale, const float* u,
                   const float* v, int count, float* out, float* inside);
void residuals(const float* const* columns, const float* beta, int number, const float* value, int count,
               float* residual);
void tukey_weights(const float* residual, const float* inside, float inverse_cut, int count, float* weight);
void normal_equations(const float* const* columns, int number, const float* weight, int count, double* lower);
void correlation_sums(const float* value, const float* target, const float* inside, int count, double sums[6]);
float agreement(const float* value, const float* target, const float* inside, int count, float gain, float offset,
                float inverse_cut);
float median_below(const float* residual, const float* inside, float limit, int count, float* scratch);
ViewSums view_sums(const float* residual, const float* target, const float* value, const float* inside, int count,
                   float inverse_cut, float visible_within);
}  // namespace scalar

}  // namespace vsfind::kernels
