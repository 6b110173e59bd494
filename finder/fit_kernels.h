#pragma once
/// @file
/// The inner loops of the pose fit in single precision, compiled for several instruction sets and chosen at run time.
/// Each has its scalar twin in `namespace scalar`; they agree within rounding (sums are added in another order).
///
/// Arrays of points as in point_block.h.

#include "finder/point_block.h"

namespace vsfind::kernels {

/// Most columns of normal_equations(), the target among them.
inline constexpr int most_columns = 15;

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
