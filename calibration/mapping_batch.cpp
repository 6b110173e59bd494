#include <limits>

#include "acquisition/errors.h"
#include "calibration/distortion.h"
#include "calibration/mapping.h"

// The loops below have no branches inside and no calls, so that the compiler vectorizes them: for any processor and for
// AVX2, chosen when the program starts. Both do the same operations in the same order (see CMakeLists.txt), so the
// results are the same to the bit. Sanitizers run before such choices can be made.
#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define VSFIND_BEST_TARGET __attribute__((target_clones("avx2", "default")))
#else
#define VSFIND_BEST_TARGET
#endif

namespace vsfind {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// (x, y) of local points times a 3x3 matrix.
struct Homography {
  double a00, a01, a02, a10, a11, a12, a20, a21, a22;
  explicit Homography(const Eigen::Matrix3d& m)
      : a00(m(0, 0)),
        a01(m(0, 1)),
        a02(m(0, 2)),
        a10(m(1, 0)),
        a11(m(1, 1)),
        a12(m(1, 2)),
        a20(m(2, 0)),
        a21(m(2, 1)),
        a22(m(2, 2)) {}
};

template <typename Real>
struct Arrays {
  std::size_t size;
  const Real* __restrict x;
  const Real* __restrict y;
  Real* __restrict image_x;
  Real* __restrict image_y;
};

template <typename Real>
inline void affine_loop(const Homography& h, const Arrays<Real>& a) {
  for (std::size_t i = 0; i < a.size; ++i) {
    const double x = a.x[i];
    const double y = a.y[i];
    a.image_x[i] = static_cast<Real>(h.a00 * x + h.a01 * y + h.a02);
    a.image_y[i] = static_cast<Real>(h.a10 * x + h.a11 * y + h.a12);
  }
}

template <typename Real>
inline void homography_loop(const Homography& h, const Arrays<Real>& a) {
  for (std::size_t i = 0; i < a.size; ++i) {
    const double x = a.x[i];
    const double y = a.y[i];
    const double w = h.a20 * x + h.a21 * y + h.a22;
    const double inverse = w > 0.0 ? 1.0 / w : nan;
    a.image_x[i] = static_cast<Real>((h.a00 * x + h.a01 * y + h.a02) * inverse);
    a.image_y[i] = static_cast<Real>((h.a10 * x + h.a11 * y + h.a12) * inverse);
  }
}

struct LensInPixels {
  distortion::Coefficients k;
  double limit;
  double fx, fy, cx, cy;  // of the picture, field lines included
};

template <typename Real, typename Distort>
inline void lens_loop(const Homography& h, const LensInPixels& lens, const Arrays<Real>& a, Distort distort) {
  for (std::size_t i = 0; i < a.size; ++i) {
    const double x = a.x[i];
    const double y = a.y[i];
    const double w = h.a20 * x + h.a21 * y + h.a22;
    const double inverse = w > 0.0 ? 1.0 / w : nan;
    const double ray_x = (h.a00 * x + h.a01 * y + h.a02) * inverse;
    const double ray_y = (h.a10 * x + h.a11 * y + h.a12) * inverse;
    const double cx = ray_x * ray_x + ray_y * ray_y <= lens.limit ? lens.cx : nan;
    const distortion::Point p = distort(lens.k, ray_x, ray_y);
    a.image_x[i] = static_cast<Real>(lens.fx * p.x + cx);
    a.image_y[i] = static_cast<Real>(lens.fy * p.y + (cx - lens.cx + lens.cy));
  }
}

// Targets are chosen for functions, not for templates.
VSFIND_BEST_TARGET void map_affine(const Homography& h, const Arrays<double>& a) { affine_loop(h, a); }
VSFIND_BEST_TARGET void map_homography(const Homography& h, const Arrays<double>& a) { homography_loop(h, a); }
VSFIND_BEST_TARGET void map_brown(const Homography& h, const LensInPixels& lens, const Arrays<double>& a) {
  lens_loop(h, lens, a, distortion::brown);
}
VSFIND_BEST_TARGET void map_polynomial(const Homography& h, const LensInPixels& lens, const Arrays<double>& a) {
  lens_loop(h, lens, a, distortion::polynomial);
}
VSFIND_BEST_TARGET void map_fisheye(const Homography& h, const LensInPixels& lens, const Arrays<double>& a) {
  lens_loop(h, lens, a, distortion::fisheye);
}
VSFIND_BEST_TARGET void map_affine(const Homography& h, const Arrays<float>& a) { affine_loop(h, a); }
VSFIND_BEST_TARGET void map_homography(const Homography& h, const Arrays<float>& a) { homography_loop(h, a); }
VSFIND_BEST_TARGET void map_brown(const Homography& h, const LensInPixels& lens, const Arrays<float>& a) {
  lens_loop(h, lens, a, distortion::brown);
}
VSFIND_BEST_TARGET void map_polynomial(const Homography& h, const LensInPixels& lens, const Arrays<float>& a) {
  lens_loop(h, lens, a, distortion::polynomial);
}
VSFIND_BEST_TARGET void map_fisheye(const Homography& h, const LensInPixels& lens, const Arrays<float>& a) {
  lens_loop(h, lens, a, distortion::fisheye);
}

}  // namespace

template <typename Real>
void Mapping::project_many(const PlaneFromLocal& pose, std::span<const Real> x, std::span<const Real> y,
                           std::span<Real> image_x, std::span<Real> image_y) const {
  if (y.size() != x.size() || image_x.size() != x.size() || image_y.size() != x.size()) {
    throw UsageError("projecting points: the arrays differ in length");
  }
  Eigen::Matrix3d local = Eigen::Matrix3d::Identity();
  local.topLeftCorner<2, 2>() = pose.linear;
  local.topRightCorner<2, 1>() = pose.offset;
  Eigen::Matrix3d m = out_from_plane_ * local;
  const double step = line_step(field_);
  const PinholeCamera& c = lens_.camera();
  if (kind_ == Kind::lens && !lens_.distorts()) {
    m.row(0) = (c.fx * m.row(0) + c.cx * m.row(2)).eval();
    m.row(1) = (c.fy * m.row(1) + c.cy * m.row(2)).eval();
  }
  const Arrays<Real> arrays{x.size(), x.data(), y.data(), image_x.data(), image_y.data()};
  if (!distorts()) {
    m.row(1) = (m.row(1) - first_line(field_) * m.row(2)).eval() / step;
    return kind_ == Kind::affine ? map_affine(Homography(m), arrays) : map_homography(Homography(m), arrays);
  }
  const Homography h(m);
  const LensInPixels lens{
      lens_.coefficients(), lens_.max_radius2(), c.fx, c.fy / step, c.cx, (c.cy - first_line(field_)) / step};
  if (lens_.model() == LensModel::fisheye) return map_fisheye(h, lens, arrays);
  if (lens_.coefficient_count() <= 5) return map_brown(h, lens, arrays);
  map_polynomial(h, lens, arrays);
}

void Mapping::image_from_local(const PlaneFromLocal& pose, std::span<const double> x, std::span<const double> y,
                               std::span<double> image_x, std::span<double> image_y) const {
  project_many(pose, x, y, image_x, image_y);
}

void Mapping::image_from_local(const PlaneFromLocal& pose, std::span<const float> x, std::span<const float> y,
                               std::span<float> image_x, std::span<float> image_y) const {
  project_many(pose, x, y, image_x, image_y);
}

}  // namespace vsfind
