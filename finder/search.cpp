#include "finder/search.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "acquisition/errors.h"
#include "finder/edges.h"
#include "finder/pattern_search.h"
#include "finder/training_scene.h"

namespace vsfind {

namespace {

void check(const SearchOptions& options) {
  const auto part = [](const char* key, double value) {
    if (!(value >= 0.0 && value <= 1.0))
      throw UsageError(fmt::format("{} {} is out of range (allowed: 0 to 1)", key, value));
  };
  part("min_score", options.min_score);
  if (options.coarse_score) part("coarse_score", *options.coarse_score);
  part("max_overlap", options.max_overlap);
  if (options.max_instances < 0) {
    throw UsageError(
        fmt::format("max_instances {} is out of range (allowed: 0 for all, or more)", options.max_instances));
  }
  if (options.threads < 1 || options.threads > 64) {
    throw UsageError(fmt::format("threads {} is out of range (allowed: 1 to 64)", options.threads));
  }
  if (!(options.timeout_ms >= 0.0)) {
    throw UsageError(fmt::format("timeout_ms {} is out of range (allowed: 0 for none, or more)", options.timeout_ms));
  }
  if (options.region && (options.region->width < 1 || options.region->height < 1)) {
    throw UsageError(fmt::format("region {},{},{},{} is empty (allowed: X,Y,W,H with W and H at least 1)",
                                 options.region->x, options.region->y, options.region->width, options.region->height));
  }
}

/// The picture prepared for all patterns that see it the same way.
struct PreparedScene {
  bool edges = false;
  double threshold = 0.0;
  HalvingPlan plan;
  EdgeImage edge_image;
  Pyramid pyramid;
  ImageView view;
  bool fresh = false;

  [[nodiscard]] bool serves(const Pattern& pattern, const HalvingPlan& wanted) const {
    if (edges != pattern.edges || (edges && threshold != pattern.edge_threshold)) return false;
    // Deeper plans begin like shallower ones.
    if (plan.steps.size() < wanted.steps.size()) return false;
    for (std::size_t i = 0; i < wanted.steps.size(); ++i) {
      if (plan.steps[i].x != wanted.steps[i].x || plan.steps[i].y != wanted.steps[i].y) return false;
    }
    return true;
  }
};

}  // namespace

struct Finder::State {
  SearchOptions options;
  std::vector<std::shared_ptr<const Pattern>> patterns;
  std::vector<PreparedPattern> prepared;
  std::vector<std::unique_ptr<PreparedScene>> scenes;
  /// How the picture is halved for a pattern, and for which size of its pixels.
  struct Planned {
    Eigen::Vector2d pixel_size{0.0, 0.0};
    HalvingPlan plan;
  };
  std::vector<Planned> plans;
  std::vector<std::size_t> order;  ///< of the patterns: the deepest first, its pyramid serves the others
  std::vector<PatternSearch> searches;
  std::vector<PatternMatches> results;
  ThreadPool threads;
  double search_ms = 0.0;

  explicit State(const SearchOptions& asked) : options(asked), threads(asked.threads) {}

  PreparedScene& scene_for(std::size_t index, const ImageView& image, const Mapping& mapping) {
    const Pattern& pattern = *patterns[index];
    Planned& planned = plans[index];
    const Eigen::Vector2d size = pixel_size(mapping, {(image.width - 1) / 2.0, (image.height - 1) / 2.0});
    if (planned.pixel_size != size)
      planned = {size, HalvingPlan::for_pixel_size(size.x(), size.y(), pattern.top_level)};
    const HalvingPlan& plan = planned.plan;
    PreparedScene* scene = nullptr;
    for (const auto& each : scenes) {
      if (each->serves(pattern, plan)) scene = each.get();
    }
    if (scene == nullptr) {
      scenes.push_back(std::make_unique<PreparedScene>());
      scene = scenes.back().get();
      scene->edges = pattern.edges;
      scene->threshold = pattern.edge_threshold;
      scene->plan = plan;
    }
    if (!scene->fresh) {
      scene->view = scene->edges ? scene->edge_image.compute(image, scene->threshold) : image;
      scene->pyramid.build(scene->view, scene->plan);
      scene->fresh = true;
    }
    return *scene;
  }
};

Finder::Finder(std::vector<std::shared_ptr<const Pattern>> patterns, const SearchOptions& options) {
  check(options);
  state_ = std::make_unique<State>(options);
  state_->patterns = std::move(patterns);
  for (const auto& pattern : state_->patterns) state_->prepared.emplace_back(pattern, options);
  state_->searches.resize(state_->patterns.size());
  state_->results.resize(state_->patterns.size());
  state_->plans.resize(state_->patterns.size());
  std::vector<std::size_t>& order = state_->order;
  for (std::size_t i = 0; i < state_->patterns.size(); ++i) order.push_back(i);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return state_->patterns[a]->top_level > state_->patterns[b]->top_level;
  });
}

Finder::~Finder() = default;
Finder::Finder(Finder&&) noexcept = default;
Finder& Finder::operator=(Finder&&) noexcept = default;

const std::vector<std::shared_ptr<const Pattern>>& Finder::patterns() const { return state_->patterns; }

double Finder::search_ms() const { return state_->search_ms; }

const std::vector<PatternMatches>& Finder::find(const ImageView& image, const Mapping& mapping) {
  using clock = std::chrono::steady_clock;
  const clock::time_point started = clock::now();
  State& s = *state_;
  const clock::time_point deadline =
      s.options.timeout_ms > 0.0 ? started + std::chrono::duration_cast<clock::duration>(
                                                 std::chrono::duration<double, std::milli>(s.options.timeout_ms))
                                 : clock::time_point::max();
  for (const auto& scene : s.scenes) scene->fresh = false;
  for (const std::size_t i : s.order) {
    if (image.empty()) {
      s.results[i] = {};
      continue;
    }
    PreparedScene& scene = s.scene_for(i, image, mapping);
    s.searches[i].run(s.prepared[i], {scene.view, &scene.pyramid, &mapping}, s.options, s.threads, deadline,
                      s.results[i]);
  }
  s.search_ms = std::chrono::duration<double, std::milli>(clock::now() - started).count();
  return s.results;
}

}  // namespace vsfind
