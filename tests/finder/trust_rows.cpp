/// Whether answers can be trusted: false alarms, every instance once, honest sigmas; and what size costs.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "dump.h"
#include "rows.h"
#include "stage.h"

namespace vsfind::measure {
namespace {

/// 1,000 cluttered scenes without the pattern: no match at the default minimum score.
bool false_alarms(const Settings& settings) {
  SearchOptions low;
  const double least = low.min_score;
  low.min_score = std::min(0.3, least);
  bool ok = true;
  for (const bool edges : {false, true}) {
    Row row;
    row.name = edges ? "false alarms, edges" : "false alarms";
    std::vector<double> scores;
    int alarms = 0;
    for (const Kind kind : {Kind::bullseye, Kind::artwork}) {
      Training training;
      training.kind = kind;
      training.edges = edges;
      training.seed = settings.seed;
      const Trained trained = train_on(training);
      Finder finder = finder_for(trained, low);
      for (int i = 0; i < (edges ? 1 : 5) * settings.scenes / 2; ++i) {
        const auto seed =
            settings.seed * 300007 + static_cast<std::uint64_t>(2 * i) + (kind == Kind::artwork ? 1U : 0U);
        Recipe recipe;
        recipe.instances = 0;
        recipe.clutter = i % 2 == 0 ? 40 : 150;
        recipe.decoys = 0.25;
        const Shot shot = random_shot(trained, recipe, seed);
        const auto& matches = finder.find(shot.picture.view(), shot.mapping).front().matches;
        row.ms.push_back(finder.search_ms());
        ++row.scenes;
        const double score = matches.empty() ? 0.0 : matches.front().score;
        scores.push_back(score);
        if (score < least) continue;
        ++alarms;
        if (!dump_folder.empty())
          dump(dump_folder, fmt::format("{}-{}", row.name, seed), shot, *trained.pattern, matches);
      }
    }
    std::sort(scores.begin(), scores.end());
    const auto at = [&](double part) {
      return scores[static_cast<std::size_t>(part * static_cast<double>(scores.size() - 1))];
    };
    row.target = fmt::format("none at the default minimum score {}", least);
    row.extra =
        fmt::format("{} alarms; scores: median {:.3f}, 99% {:.3f}, highest {:.3f}", alarms, at(0.5), at(0.99), at(1.0));
    row.ok = alarms == 0;
    print(row);
    ok = ok && row.ok;
  }
  return ok;
}

/// 8 of 8 instances, each once.
bool instances(const Settings& settings) {
  Training training;
  training.kind = Kind::small_artwork;
  training.angle = {-180.0, 180.0};
  training.seed = settings.seed;
  const Trained trained = train_on(training);
  SearchOptions options;
  options.max_instances = 0;
  options.min_score = 0.6;  // clutter lies under the parts, too
  Finder finder = finder_for(trained, options);
  Recipe recipe;
  recipe.instances = 8;
  recipe.angle_limit = 180.0;
  recipe.quiet_zone = false;
  recipe.clutter = 15;
  recipe.decoys = 0.0;
  Row row;
  row.name = "8 instances, full circle";
  int whole = 0;
  int surplus = 0;
  const int scenes = std::max(1, settings.scenes / 2);
  for (int i = 0; i < scenes; ++i) {
    const auto seed = settings.seed * 400009 + static_cast<std::uint64_t>(i);
    const Shot shot = random_shot(trained, recipe, seed);
    const int before = row.right;
    const std::size_t found = judge(finder, trained, shot, row, seed).size();
    whole += row.right - before == 8 && shot.truth.size() == 8 && found == 8 ? 1 : 0;
    surplus += static_cast<int>(found) > 8 ? static_cast<int>(found) - 8 : 0;
  }
  row.target = "8 of 8 once each in every scene, min score 0.6";
  row.extra = fmt::format("{} of {} scenes whole, {} matches too many", whole, scenes, surplus);
  row.ok = whole == scenes;
  print(row);
  return row.ok;
}

/// The ratio of real errors to predicted sigmas.
bool sigmas(const Settings& settings) {
  bool ok = true;
  for (const Kind kind : {Kind::bullseye, Kind::artwork}) {
    for (const double noise : {2.0, 5.0, 10.0}) {
      Row row;
      row.name = fmt::format("sigma, {}, noise {}", name(kind), noise);
      const int trainings = 5;
      for (int t = 0; t < trainings; ++t) {
        Training training;
        training.kind = kind;
        training.seed = settings.seed * 17 + static_cast<std::uint64_t>(t);
        const Trained trained = train_on(training);
        Finder finder = finder_for(trained, {});
        Recipe recipe;
        recipe.sensor.noise = noise;
        for (int i = 0; i < settings.scenes / trainings; ++i) {
          const auto seed = settings.seed * 500009 + static_cast<std::uint64_t>(1000 * t + i);
          judge(finder, trained, random_shot(trained, recipe, seed), row, seed);
        }
      }
      const double ratios[] = {row.ratio_x.rms(), row.ratio_y.rms(), row.ratio_angle.rms()};
      row.target = "r.m.s. of error/sigma in 0.7 ... 1.4";
      row.extra = fmt::format("x {:.2f} y {:.2f} angle {:.2f}", ratios[0], ratios[1], ratios[2]);
      row.ok = std::all_of(std::begin(ratios), std::end(ratios), [](double r) { return r >= 0.7 && r <= 1.4; });
      print(row);
      ok = ok && row.ok;
    }
  }
  return ok;
}

/// The exponent of growth between neighbouring sizes, fitted over all of them.
double exponent(const std::vector<double>& sizes, const std::vector<double>& times) {
  double sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
  const auto n = static_cast<double>(sizes.size());
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const double x = std::log(sizes[i]);
    const double y = std::log(std::max(times[i], 1e-6));
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
  }
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

/// Time of training and search as pattern and picture grow alike, from half to four times the paper's size.
bool growth(const Settings& settings) {
  const std::vector<double> sizes{0.5, 1.0, 2.0, 4.0};
  std::vector<double> train_times;
  std::vector<double> search_times;
  bool ok = true;
  for (const double size : sizes) {
    Training training;
    training.size = size;
    training.seed = settings.seed;
    const Trained trained = train_on(training);
    Finder finder = finder_for(trained, {});
    Row row;
    row.name = fmt::format("size x {}", size);
    for (int i = 0; i < 7; ++i) {
      render::Sensor sensor;
      sensor.seed = settings.seed * 600011 + static_cast<std::uint64_t>(i);
      const Pose pose{320.0 * size + i, 240.0 * size - i, -40.0 + 13.0 * i, 1.0, 1.0};
      judge(finder, trained, sheet_shot(trained, pose, 0.7, sensor), row, sensor.seed);
    }
    train_times.push_back(trained.pattern->report.training_ms);
    search_times.push_back(median(row.ms));
    row.target = size == 1.0 ? "all, training < 1 s" : "all";
    row.extra = fmt::format("training {:.0f} ms", train_times.back());
    row.ok = row.right == row.expected && (size != 1.0 || train_times.back() < 1000.0);
    print(row);
    ok = ok && row.ok;
  }
  const double training = exponent(sizes, train_times);
  const double search = exponent(sizes, search_times);
  const bool reached = training <= 2.5 && search <= 2.2;
  fmt::print("    growth: training n^{:.2f} (paper 3.5, aim 2.5), search n^{:.2f} (paper 2.5, aim 2.2) {}\n", training,
             search, reached ? "ok" : "FAIL");
  return ok && reached;
}

}  // namespace

std::vector<Entry> trust_rows() {
  return {{"false alarms", false_alarms}, {"instances", instances}, {"sigma", sigmas}, {"growth", growth}};
}

}  // namespace vsfind::measure
