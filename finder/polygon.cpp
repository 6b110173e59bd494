#include "finder/polygon.h"

#include <cmath>

namespace vsfind {

double area(const Polygon& polygon) {
  double twice = 0.0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& a = polygon[i];
    const Eigen::Vector2d& b = polygon.after(i);
    twice += a.x() * b.y() - b.x() * a.y();
  }
  return std::abs(twice) / 2.0;
}

double shared_area(const Polygon& a, const Polygon& b) {
  // Sutherland & Hodgman: cut polygon a along every side of b.
  Polygon rest = a;
  for (std::size_t i = 0; i < b.size() && rest.size() > 0; ++i) {
    const Eigen::Vector2d& from = b[i];
    const Eigen::Vector2d along = b.after(i) - from;
    const auto side = [&](const Eigen::Vector2d& p) {
      return along.x() * (p.y() - from.y()) - along.y() * (p.x() - from.x());
    };
    Polygon kept;
    for (std::size_t k = 0; k < rest.size(); ++k) {
      const Eigen::Vector2d& p = rest[k];
      const Eigen::Vector2d& q = rest.after(k);
      const double sp = side(p);
      const double sq = side(q);
      if (sp >= 0.0) kept.add(p);
      if ((sp >= 0.0) != (sq >= 0.0)) kept.add(p + (q - p) * (sp / (sp - sq)));
    }
    rest = kept;
  }
  return area(rest);
}

}  // namespace vsfind
