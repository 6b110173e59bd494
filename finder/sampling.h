#pragma once
/// @file
/// Reading a picture between its pixels.

#include "acquisition/image_view.h"
#include "finder/points.h"
#include "finder/pyramid.h"

namespace vsfind {

/// Reads a picture at places given from one of its pixels (kernels::ReadPlane says why); arrays padded as in
/// point_block.h. Where a point is too near the border (or NaN), inside[i] and out[i] are 0; else inside[i] is 1.
/// Values are scaled to 0 … 255.
class Reader {
 public:
  Reader() = default;
  Reader(const Reader&) = default;
  Reader& operator=(const Reader&) = default;
  virtual ~Reader() = default;
  virtual void read(const Places& places, int count, float* out, float* inside) const = 0;
};

/// Bilinear interpolation between the pixels of one level.
class BilinearReader final : public Reader {
 public:
  explicit BilinearReader(const Level& level) : level_(level) {}
  void read(const Places& places, int count, float* out, float* inside) const override;
  /// In double precision, for training: level coordinates.
  void read(const double* u, const double* v, int count, double* out, double* inside) const;

 private:
  Level level_;
};

/// Reads a level as BilinearReader reads its smoothed copy, without making that copy.
class SmoothingReader final : public Reader {
 public:
  explicit SmoothingReader(const Level& level) : level_(level) {}
  void read(const Places& places, int count, float* out, float* inside) const override;

 private:
  Level level_;
};

/// Reads a picture through a Gaussian of a few pixels' width: what lies near the sampling limit is damped before it can
/// bias the sub-pixel position. 8 × 8 taps, weights normalized to 1.
class GaussianReader final : public Reader {
 public:
  /// Widths in pixels of the picture.
  GaussianReader(const ImageView& image, double sigma_x, double sigma_y)
      : image_(image), sigma_x_(sigma_x), sigma_y_(sigma_y) {}

  static constexpr int taps = 8;

  void read(const Places& places, int count, float* out, float* inside) const override;
  /// In double precision, for training: picture coordinates.
  void read(const double* u, const double* v, int count, double* out, double* inside) const;
  /// Value, both first derivatives (per pixel) and the Laplacian of the smoothed picture at one point; false outside.
  bool read_with_derivatives(double u, double v, double out[4]) const;

 private:
  ImageView image_;
  double sigma_x_;
  double sigma_y_;
};

}  // namespace vsfind
