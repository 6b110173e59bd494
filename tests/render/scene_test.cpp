/// The renderer proves itself: positions by moments, areas, blur, fields.
#include "app/render/scene.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <numbers>

#include "app/render/patterns.h"
#include "app/render/random.h"
#include "app/render/sensor.h"

namespace vsfind::render {
namespace {

struct Moments {
  double mass = 0.0;
  Eigen::Vector2d centre{0, 0};
  double xx = 0.0, xy = 0.0, yy = 0.0;
};

/// Of what differs from the background, over the rows as they lie in the frame.
Moments moments(const Exposure& exposure, double background, Field field = Field::frame) {
  Moments m;
  for (int pass = 0; pass < 2; ++pass) {
    for (int row = 0; row < exposure.height; ++row) {
      for (int x = 0; x < exposure.width; ++x) {
        const double w = static_cast<double>(exposure.at(x, row)) - background;
        if (std::abs(w) < 1e-3) continue;  // the rounding of float, which has long arms
        const double y = line_step(field) * row + first_line(field);
        if (pass == 0) {
          m.mass += w;
          m.centre += w * Eigen::Vector2d(x, y);
        } else {
          const Eigen::Vector2d d = Eigen::Vector2d(x, y) - m.centre;
          m.xx += w * d.x() * d.x();
          m.xy += w * d.x() * d.y();
          m.yy += w * d.y() * d.y();
        }
      }
    }
    if (pass == 0) m.centre /= m.mass;
  }
  m.xx /= m.mass;
  m.xy /= m.mass;
  m.yy /= m.mass;
  return m;
}

Scene with(const Drawing& drawing, const Pose& pose, int width = 160, int height = 140) {
  Scene scene;
  scene.width = width;
  scene.height = height;
  scene.background = 100.0;
  scene.items.push_back({drawing, pose});
  return scene;
}

TEST(Expose, DiscLiesWhereItWasPut) {
  for (const double blur : {0.0, 0.7, 2.0}) {
    for (int i = 0; i < 8; ++i) {
      const Pose pose{80.0 + 0.137 * i, 70.0 - 0.0731 * i, 0, 1, 1};
      const Moments m = moments(expose(with(disc(80.0, 200.0), pose), blur), 100.0);
      EXPECT_NEAR(m.centre.x(), pose.x, 1e-4) << blur;
      EXPECT_NEAR(m.centre.y(), pose.y, 1e-4) << blur;
    }
  }
}

TEST(Expose, KeepsTheWholeLight) {
  for (const double blur : {0.0, 0.7, 5.0}) {
    const Moments m = moments(expose(with(disc(60.0, 250.0), {80.3, 69.2, 0, 1, 1}), blur), 100.0);
    EXPECT_NEAR(m.mass, 150.0 * std::numbers::pi * 900.0, 1e-4 * m.mass) << blur;
    const Moments hollow = moments(expose(with(ring(60.0, 30.0, 250.0), {80.3, 69.2, 0, 1, 1}), blur), 100.0);
    EXPECT_NEAR(hollow.mass, 150.0 * std::numbers::pi * 675.0, 1e-4 * hollow.mass) << blur;
  }
}

/// Second moments of a uniform bar of a × b: a²/12, b²/12; a pixel adds 1/12, the blur its variance.
TEST(Expose, TurnsAndBlursAsAsked) {
  const Drawing bar{{{{rectangle(-35.0, -10.0, 35.0, 10.0)}, 200.0}}, 70.0, 20.0};
  for (const double blur : {0.7, 1.3, 3.0}) {
    for (const double angle : {0.0, 17.0, -33.3, 90.0, 135.0}) {
      const Moments m = moments(expose(with(bar, {79.6, 70.3, angle, 1.1, 0.9}), blur), 100.0);
      const double turn = 0.5 * std::atan2(2.0 * m.xy, m.xx - m.yy) * 180.0 / std::numbers::pi;
      EXPECT_NEAR(std::remainder(turn - angle, 180.0), 0.0, 1e-3);
      const double variance = (77.0 * 77.0 + 18.0 * 18.0 + 2.0) / 12.0 + 2.0 * blur * blur;
      EXPECT_NEAR(m.xx + m.yy, variance, 0.002 * (1.0 + blur * blur)) << blur << ' ' << angle;
    }
  }
}

/// Straight edges at many places within a pixel: every pixel of the profile against the formula.
TEST(Expose, EdgesHaveTheGaussiansProfile) {
  for (const double blur : {0.0, 0.4, 0.7, 1.4, 2.0}) {
    double worst = 0.0;
    for (int i = 0; i < 40; ++i) {
      const double at = 20.0 + 0.0253 * i;
      const Drawing half{{{{rectangle(-300.0, -300.0, 0.0, 300.0)}, 220.0}}, 1, 1};
      const Exposure along_x = expose(with(half, {at, 20.0, 0, 1, 1}, 40, 40), blur);
      const Exposure along_y = expose(with(half, {20.0, at, 90, 1, 1}, 40, 40), blur);
      const auto ramp = [&](double u) {
        if (blur == 0.0) return std::max(u, 0.0);
        return u * 0.5 * std::erfc(-u / blur / std::numbers::sqrt2) +
               blur * std::exp(-0.5 * u * u / blur / blur) / std::sqrt(2.0 * std::numbers::pi);
      };
      for (int x = 0; x < 40; ++x) {
        const double expected = 100.0 + 120.0 * (ramp(at - x + 0.5) - ramp(at - x - 0.5));
        worst = std::max(worst, std::abs(static_cast<double>(along_x.at(x, 20)) - expected));
        worst = std::max(worst, std::abs(static_cast<double>(along_y.at(20, x)) - expected));
      }
    }
    std::printf("blur %.1f: edge profile off by at most %.4f of 120 grey levels\n", blur, worst);
    EXPECT_LT(worst, blur == 0.0 ? 0.0005 : 0.08) << blur;
  }
}

/// What a least-squares finder would see of the cells: the apparent shift against cells four times as fine, which by
/// the third order of the error are 64 times as good.
TEST(Expose, CellsMoveNothingBy0Point0003Pixels) {
  for (const double blur : {0.3, 0.5, 0.6, 0.7, 1.0, 2.0, 4.0}) {
    double worst = 0.0;
    for (const double angle : {0.0, 3.0, 45.0}) {
      const Drawing square{{{{rectangle(-12.0, -12.0, 12.0, 12.0)}, 220.0}}, 1, 1};
      const auto shot = [&](double x, double y, int cells) {
        return expose(with(square, {x, y, angle, 1, 1}, 48, 48), blur, Field::frame, cells);
      };
      for (int i = 0; i < 9; ++i) {
        const double x = 24.0 + 0.0277 * i;
        const double y = 24.0 + 0.0391 * i;
        const double h = 0.125;
        const Exposure left = shot(x - h, y, 0);
        const Exposure right = shot(x + h, y, 0);
        const Exposure usual = shot(x, y, 0);
        const Exposure fine = shot(x, y, blur < 0.6 ? 64 : blur < 4.0 ? 32 : 16);
        // One side only: the errors of two sides of a square of whole cells' width cancel.
        double numerator = 0.0;
        double denominator = 0.0;
        for (int v = 0; v < 48; ++v) {
          for (int u = 24; u < 48; ++u) {
            const double slope = static_cast<double>(right.at(u, v) - left.at(u, v)) / (2.0 * h);
            numerator += slope * static_cast<double>(usual.at(u, v) - fine.at(u, v));
            denominator += slope * slope;
          }
        }
        worst = std::max(worst, std::abs(numerator / denominator));
      }
    }
    std::printf("blur %.1f: apparent shift of one side by the cells %.6f px\n", blur, worst);
    EXPECT_LT(worst, 0.0003) << blur;
  }
}

TEST(Expose, FieldsAreTheFramesLines) {
  const Scene scene = with(artwork(3, 90.0, 70.0), {80.4, 70.7, 12.0, 1, 1}, 161, 141);
  const Exposure frame = expose(scene, 0.7);
  const Exposure top = expose(scene, 0.7, Field::top);
  const Exposure bottom = expose(scene, 0.7, Field::bottom);
  ASSERT_EQ(top.height, 71);
  ASSERT_EQ(bottom.height, 70);
  EXPECT_EQ(weave(top, bottom).grey, frame.grey);
  const Moments a = moments(expose(with(disc(60.0), {80.3, 70.4, 0, 1, 1}), 2.0, Field::bottom), 100.0, Field::bottom);
  EXPECT_NEAR(a.centre.y(), 70.4, 0.001);
}

TEST(Expose, WhatLiesOutsideIsCutNotMoved) {
  const Drawing part = artwork(5, 120.0, 100.0);
  const Scene big = with(part, {100.3, 90.2, 25.0, 1, 1}, 200, 180);
  const Exposure whole = expose(big, 0.7);
  const Scene cut = with(part, {100.3 - 70.0, 90.2 - 60.0, 25.0, 1, 1}, 80, 70);
  const Exposure corner = expose(cut, 0.7);
  for (int y = 0; y < 70; ++y) {
    for (int x = 0; x < 80; ++x) ASSERT_NEAR(corner.at(x, y), whole.at(x + 70, y + 60), 2e-3) << x << ',' << y;
  }
}

TEST(Expose, LensMovesOutlines) {
  Scene scene = with(disc(60.0), {90.0, 80.0, 0, 1, 1}, 260, 140);
  scene.frame_from_plane = [](const Eigen::Vector2d& p) { return Eigen::Vector2d(1.5 * p.x(), 0.8 * p.y()); };
  const Moments m = moments(expose(scene, 0.7), 100.0);
  EXPECT_NEAR(m.centre.x(), 135.0, 1e-3);
  EXPECT_NEAR(m.centre.y(), 64.0, 1e-3);
  EXPECT_NEAR(m.mass, -60.0 * std::numbers::pi * 900.0 * 1.2, 1e-3 * std::abs(m.mass));
}

TEST(Develop, SameSeedSamePixelsAndNoiseAsAsked) {
  const Exposure flat = expose(with({}, {}, 200, 200), 0.7);
  Sensor sensor;
  sensor.noise = 5.0;
  sensor.seed = 42;
  const Picture a = develop(flat, sensor);
  EXPECT_EQ(a.bytes(), develop(flat, sensor).bytes());
  sensor.seed = 43;
  EXPECT_NE(a.bytes(), develop(flat, sensor).bytes());
  double sum = 0.0;
  double squares = 0.0;
  for (int y = 0; y < 200; ++y) {
    for (int x = 0; x < 200; ++x) {
      const double d = a.view().at(x, y) - 100.0;
      sum += d;
      squares += d * d;
    }
  }
  EXPECT_NEAR(sum / 40000.0, 0.0, 0.1);
  EXPECT_NEAR(std::sqrt(squares / 40000.0), std::sqrt(25.0 + 1.0 / 12.0), 0.08);
  sensor.bits = 12;
  const Picture wide = develop(flat, sensor);
  EXPECT_NEAR(wide.view().at(3, 3), 1600, 16 * 30);
  EXPECT_EQ(wide.bytes().size(), 80000U);
}

/// The generator's numbers are fixed: pictures made on one machine are made again on another.
TEST(Develop, NumbersAreTheSameEverywhere) {
  Random random(5489);
  EXPECT_EQ(random.bits(), 14514284786278117030ULL);  // the standard's first output of mt19937_64
  Random normal(1);
  double sum = 0.0;
  for (int i = 0; i < 1000; ++i) sum += normal.normal();
  EXPECT_NEAR(sum / std::sqrt(1000.0), 0.0, 4.0);
}

TEST(Expose, IsFast) {
  Scene scene = target_sheet();
  scene.items.push_back({bullseye(), {320.3, 240.1, 13.0, 1, 1}});
  const auto begin = std::chrono::steady_clock::now();
  const Exposure e = expose(scene, 0.7);
  const double ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  std::printf("640x480 in %.1f ms\n", ms);
  EXPECT_NEAR(e.at(320, 240), 40.0, 0.01);
  EXPECT_LT(ms, 2000.0);
}

}  // namespace
}  // namespace vsfind::render
