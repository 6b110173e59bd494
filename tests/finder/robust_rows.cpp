/// How surely patterns are found: random poses in clutter under every difficulty, bullseye and artwork in turn.
#include <fmt/core.h>

#include "rows.h"
#include "stage.h"

namespace vsfind::measure {
namespace {

struct Difficulty {
  std::string name;
  double target = 99.0;  ///< per cent found and right
  Recipe recipe;
  bool edges = false;
  Polarity polarity = Polarity::same;
  std::optional<double> min_score;  ///< as a user would set it who knows how much can be missing; else the default
};

std::vector<Difficulty> difficulties() {
  std::vector<Difficulty> all;
  const auto add = [&](const std::string& name, double target) -> Difficulty& {
    Difficulty d;
    d.name = name;
    d.target = target;
    all.push_back(d);
    return all.back();
  };
  add("plain", 99);
  add("noise 15", 99).recipe.sensor.noise = 15.0;
  add("blur 3 px", 99).recipe.blur = 3.0;
  {
    Recipe& r = add("contrast 1/3", 99).recipe;
    r.sensor.gain = 1.0 / 3.0;
    r.sensor.offset = 70.0;
  }
  add("strong shading", 99).recipe.random_shading = true;
  add("gamma 2.2", 99).recipe.sensor.gamma = 2.2;
  add("blur 5 px", 98).recipe.blur = 5.0;
  {
    Difficulty& d = add("gamma 0.4, edges", 98);
    d.recipe.sensor.gamma = 0.4;
    d.edges = true;
  }
  {
    Difficulty& d = add("reversed, polarity any", 98);
    d.recipe.sensor.gain = -1.0;
    d.recipe.sensor.offset = 250.0;
    d.polarity = Polarity::any;
  }
  {
    Difficulty& d = add("20% hidden", 98);
    d.recipe.hidden = 0.20;
    d.min_score = 0.5;
  }
  {
    Difficulty& d = add("dense clutter", 98);
    d.recipe.clutter = 150;
    d.recipe.decoys = 0.25;
    d.recipe.quiet_zone = false;
    d.recipe.background = {180.0, 215.0};
  }
  {
    Difficulty& d = add("35% hidden", 95);
    d.recipe.hidden = 0.35;
    d.min_score = 0.3;
  }
  {
    Difficulty& d = add("a third outside", 95);
    d.recipe.outside = 1.0 / 3.0;
    d.min_score = 0.4;
  }
  {
    Difficulty& d = add("greys remapped, edges", 95);
    d.recipe.remap = true;
    d.edges = true;
    d.min_score = 0.4;
  }
  return all;
}

bool measure(const Difficulty& difficulty, const Settings& settings) {
  SearchOptions options;
  if (difficulty.min_score) options.min_score = *difficulty.min_score;
  Row row;
  row.name = difficulty.name;
  int right_before = 0;
  int expected_before = 0;
  for (const Kind kind : {Kind::bullseye, Kind::artwork}) {
    Training training;
    training.kind = kind;
    training.edges = difficulty.edges;
    training.polarity = difficulty.polarity;
    training.seed = settings.seed;
    const Trained trained = train_on(training);
    Finder finder = finder_for(trained, options);
    for (int i = 0; i < (settings.scenes + 1) / 2; ++i) {
      const auto seed = settings.seed * 200003 + static_cast<std::uint64_t>(2 * i) + (kind == Kind::artwork ? 1U : 0U);
      const auto& matches = judge(finder, trained, random_shot(trained, difficulty.recipe, seed), row, seed);
      if (difficulty.polarity == Polarity::any && !matches.empty() && matches[0].polarity != Polarity::reversed) {
        row.ok = false;
      }
    }
    row.extra += fmt::format("{}{} {}/{}", row.extra.empty() ? "" : ", ", name(kind), row.right - right_before,
                             row.expected - expected_before);
    right_before = row.right;
    expected_before = row.expected;
  }
  if (!row.ok) row.extra += ", wrong polarity reported";
  row.target = fmt::format(">= {}%{}", difficulty.target,
                           difficulty.min_score ? fmt::format(", min score {}", *difficulty.min_score) : "");
  row.ok = row.ok && row.right_percent() >= difficulty.target;
  print(row);
  return row.ok;
}

}  // namespace

std::vector<Entry> robust_rows() {
  std::vector<Entry> entries;
  for (const Difficulty& difficulty : difficulties()) {
    entries.push_back({difficulty.name, [difficulty](const Settings& s) { return measure(difficulty, s); }});
  }
  return entries;
}

}  // namespace vsfind::measure
