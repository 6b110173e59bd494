/// Noise, bound and the analysis of a stage's travel.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "acquisition/errors.h"
#include "app/qualify/image_noise.h"
#include "app/qualify/pose_bound.h"
#include "app/qualify/qualify_options.h"
#include "app/qualify/stage_analysis.h"
#include "app/render/patterns.h"
#include "app/render/random.h"
#include "app/render/sensor.h"
#include "finder/train.h"

namespace vsfind {
namespace {

render::Picture bullseye_picture(double noise, std::uint64_t seed = 1, int bits = 8) {
  render::Scene scene = render::target_sheet();
  scene.items.push_back({render::bullseye(), {319.7, 239.2, 1.0, 1.0, 1.0}});
  render::Sensor sensor;
  sensor.noise = noise;
  sensor.seed = seed;
  sensor.bits = bits;
  return render::develop(render::expose(scene, 0.7), sensor);
}

TEST(ImageNoise, OfTheSensorAndRounding) {
  for (const double noise : {0.5, 2.0, 8.0}) {
    const double expected = std::hypot(noise, std::sqrt(1.0 / 12.0));
    EXPECT_NEAR(image_noise(bullseye_picture(noise).view()), expected, 0.03 * expected) << noise;
  }
  EXPECT_NEAR(image_noise(bullseye_picture(2.0, 1, 12).view()), 2.0, 0.06);
}

TEST(ImageNoise, OfPicturesWithoutAny) {
  EXPECT_EQ(image_noise(render::Picture(2, 2, 8).view()), 0.0);
  EXPECT_EQ(image_noise(render::Picture(64, 64, 16).view()), 0.0);  // all black is saturated
}

/// The pattern as far as the bound looks at it.
Pattern outline(double side) {
  Pattern pattern;
  pattern.width = pattern.height = side;
  pattern.left = pattern.top = -side / 2.0;
  return pattern;
}

/// Of the bull's-eye's edges, whose outermost ones count by `outermost`, in closed form.
void expect_bound_of_edges(double side, double outermost) {
  PoseBoundEstimator estimator;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    estimator.add(bullseye_picture(2.0, seed).view(), {}, outline(side), {319.7, 239.2, 1.0, 1.0, 1.0}, 2.02);
  }
  // A Gaussian edge of 160 levels holds 160² / (2·√π·s) / noise² of information per pixel of its length; s is optics
  // and pixel together. Ten vertical edges tell x, all twenty the angle.
  const double blur = std::sqrt(0.7 * 0.7 + 1.0 / 12.0);
  const double per_pixel = 160.0 * 160.0 / (2.0 * std::sqrt(std::numbers::pi) * blur) / (2.02 * 2.02);
  double length = 0.0;
  double moment = 0.0;
  for (const double half : {95.5, 75.5, 55.5, 35.5, 15.5}) {
    const double part = half == 95.5 ? outermost : 1.0;
    length += part * 4.0 * half;
    moment += part * 8.0 / 3.0 * half * half * half;
  }
  const PoseBound with = estimator.bound(true);
  EXPECT_NEAR(with.x, 1.0 / std::sqrt(length * per_pixel), 0.06 * with.x);
  EXPECT_NEAR(with.y, with.x, 0.01 * with.x);
  EXPECT_NEAR(with.angle_deg, 180.0 / std::numbers::pi / std::sqrt(moment * per_pixel), 0.08 * with.angle_deg);
  const PoseBound without = estimator.bound(false);
  EXPECT_LE(without.x, with.x * 1.0001);
  EXPECT_EQ(without.angle_deg, 0.0);
}

TEST(PoseBound, IsThatOfTheEdgesInClosedForm) { expect_bound_of_edges(197.0, 1.0); }

// What lies outside was not taught: of an edge on the border one flank counts.
TEST(PoseBound, EndsAtThePatternsBorder) {
  expect_bound_of_edges(191.0, 0.5);
  expect_bound_of_edges(181.0, 0.0);
}

TEST(PoseBound, GrowsWithTheNoise) {
  double last = 0.0;
  for (const double noise : {1.0, 2.0, 4.0, 8.0}) {
    PoseBoundEstimator estimator;
    estimator.add(bullseye_picture(noise).view(), {}, outline(191.0), {319.7, 239.2, 1.0, 1.0, 1.0}, noise);
    const double x = estimator.bound(true).x;
    EXPECT_GT(x, 1.8 * last);
    last = x;
  }
}

TEST(PoseBound, OfNothing) {
  PoseBoundEstimator estimator;
  EXPECT_EQ(estimator.bound(true).x, 0.0);
  estimator.add(render::Picture(640, 480, 8).view(), {}, outline(191.0), {319.7, 239.2, 1.0, 1.0, 1.0}, 1.0);
  EXPECT_EQ(estimator.bound(true).x, 0.0);
}

/// A stage of which everything is known: what is given is added to exact places.
StageRun run_of(StageKind kind, int steps, double noise, bool fiducials) {
  StageRun run;
  run.pattern = std::make_shared<const Pattern>();
  run.unit = "px";
  run.source = "made up";
  run.angle_searched = kind == StageKind::rotary;
  render::Random random(5);
  for (int i = 0; i < steps; ++i) {
    StageFrame& frame = run.frames.emplace_back();
    frame.step = i;
    const double angle = kind == StageKind::rotary ? 0.5 * i : 0.0;
    const Pose body{100.0 + (kind == StageKind::linear ? 0.3 * i : 0.0),
                    80.0 + (kind == StageKind::linear ? 0.4 * i : 0.0), angle, 1.0, 1.0};
    const Eigen::Vector2d pattern = plane_from_pattern(body, {20.0, -10.0});
    Match match;
    match.frame_position.setZero();
    match.pose = {pattern.x() + noise * random.normal(), pattern.y() + noise * random.normal(),
                  angle + 30.0 + noise * random.normal(), 1.0, 1.0};
    frame.match = match;
    frame.search_ms = i + 1.0;
    if (fiducials) frame.fiducials = FiducialPose{Eigen::Vector2d(body.x, body.y), angle, 0.0, 0.0};
  }
  return run;
}

TEST(StageAnalysis, LinearStage) {
  const StageAnalysis exact = analyse_stage(run_of(StageKind::linear, 10, 0.0, true), StageKind::linear);
  EXPECT_NEAR(exact.travel, 4.5, 1e-9);
  EXPECT_NEAR(exact.direction_deg, std::atan2(0.4, 0.3) * 180.0 / std::numbers::pi, 1e-6);
  EXPECT_LT(exact.pattern_across.spread.max, 1e-9);
  EXPECT_LT(exact.pattern_along.spread.max, 1e-9);
  EXPECT_LT(exact.relative_max, 1e-9);
  EXPECT_EQ(exact.found, 10U);
  EXPECT_EQ(exact.with_fiducials, 10U);
  EXPECT_DOUBLE_EQ(exact.median_ms, 5.0);
  EXPECT_DOUBLE_EQ(exact.max_ms, 10.0);
  const StageAnalysis noisy = analyse_stage(run_of(StageKind::linear, 400, 0.01, true), StageKind::linear);
  EXPECT_NEAR(noisy.pattern_across.spread.sd, 0.01, 0.0015);
  EXPECT_NEAR(noisy.pattern_along.spread.sd, 0.01, 0.0015);
  EXPECT_NEAR(per_axis(noisy.relative_x, noisy.relative_y), 0.01, 0.001);
  EXPECT_LT(noisy.fiducials_across.spread.max, 1e-9);
}

TEST(StageAnalysis, RotaryStageWhosePatternLiesBesideTheFiducialsCentre) {
  const StageAnalysis exact = analyse_stage(run_of(StageKind::rotary, 20, 0.0, true), StageKind::rotary);
  EXPECT_NEAR(exact.travel, 9.5, 1e-9);
  EXPECT_LT(exact.relative_max, 1e-9);
  EXPECT_LT(exact.relative_angle.spread.max, 1e-9);
  EXPECT_LT(exact.pattern_turn.spread.max, 1e-9);
  const StageAnalysis noisy = analyse_stage(run_of(StageKind::rotary, 400, 0.01, true), StageKind::rotary);
  EXPECT_NEAR(noisy.relative_angle.spread.sd, 0.01, 0.001);
}

TEST(StageAnalysis, FramesWithoutPatternOrFiducialsAreLeftOut) {
  StageRun run = run_of(StageKind::linear, 10, 0.0, true);
  run.frames[3].match.reset();
  run.frames[6].fiducials.reset();
  const StageAnalysis analysis = analyse_stage(run, StageKind::linear);
  EXPECT_EQ(analysis.found, 9U);
  EXPECT_EQ(analysis.with_fiducials, 8U);
  EXPECT_LT(analysis.pattern_along.spread.max, 1e-9);  // the gap is counted as a step
  EXPECT_TRUE(std::isnan(analysis.relative_x.values[6]));
  for (std::size_t i = 2; i < 10; ++i) run.frames[i].match.reset();
  EXPECT_THROW(static_cast<void>(analyse_stage(run, StageKind::linear)), UsageError);
}

/// A simulated stage's pictures without some of them: as the camera counts, those were lost or damaged.
class Lossy final : public FrameSource {
 public:
  explicit Lossy(const SimulatedStage& stage) : stage_(open_stage(stage)) {}
  [[nodiscard]] const SourceInfo& info() const override { return stage_->info(); }
  std::optional<Frame> next() override {
    auto frame = stage_->next();
    if (frame && frame->info().sequence == 2) frame = stage_->next();  // lost
    if (!frame || frame->info().sequence != 4) return frame;
    FrameInfo damaged = frame->info();
    damaged.status = FrameStatus::incomplete;
    return Frame(nullptr, 0, {}, damaged);
  }
  void stop() noexcept override {}

 private:
  std::unique_ptr<FrameSource> stage_;
};

TEST(StageRun, StepsThatTheCameraLostAreCounted) {
  SimulationOptions options;
  options.steps = 8;
  const Simulation simulation = simulate_stages(options);
  TrainOptions training;
  training.roi = simulation.roi;
  StageRequest wanted;
  wanted.pattern = std::make_shared<const Pattern>(train(simulation.training.view(), Mapping(), training));
  Lossy source(simulation.linear);
  const auto runs = run_stage(source, {wanted}, 5);
  ASSERT_EQ(runs.size(), 1U);
  std::vector<double> steps;
  for (const auto& frame : runs[0].frames) steps.push_back(frame.step);
  EXPECT_EQ(steps, (std::vector<double>{0.0, 1.0, 3.0, 5.0, 6.0}));
  EXPECT_EQ(runs[0].bad_frames, 1U);
  const StageAnalysis analysis = analyse_stage(runs[0], StageKind::linear);
  EXPECT_EQ(analysis.steps, 6.0);
  EXPECT_NEAR(analysis.travel, 6.0 * simulation_step_px, 0.01);
  EXPECT_LT(analysis.pattern_along.spread.max, 0.02);
}

TEST(QualifyOptions, ListOfAccuracies) {
  EXPECT_EQ(parse_accuracies("10,20,30"), (std::vector<int>{10, 20, 30}));
  EXPECT_EQ(parse_accuracies("7"), std::vector<int>{7});
  for (const char* wrong : {"", "10,", "0", "101", "10;20", "ten"}) {
    EXPECT_THROW(static_cast<void>(parse_accuracies(wrong)), ValueError) << wrong;
  }
}

}  // namespace
}  // namespace vsfind
