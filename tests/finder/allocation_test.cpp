/// Counts what the search takes from the heap: nothing, once it has seen a picture of each kind.
#include <gtest/gtest.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <memory>

#include "app/render/patterns.h"
#include "app/render/sensor.h"
#include "finder/search.h"
#include "finder/train.h"

namespace {
std::atomic<long> taken{0};
}

// Every way to the heap, not only operator new: Eigen takes its memory from malloc itself.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
extern "C" void __sanitizer_malloc_hook(const volatile void* /*memory*/, std::size_t /*size*/) { ++taken; }
#else
// NOLINTBEGIN(bugprone-reserved-identifier): the names are the C library's.
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

void* malloc(std::size_t size) noexcept {
  ++taken;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) noexcept {
  ++taken;
  return __libc_calloc(count, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  ++taken;
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) noexcept {
  ++taken;
  *memory = __libc_memalign(alignment, size);
  return *memory == nullptr ? ENOMEM : 0;
}
}
// NOLINTEND(bugprone-reserved-identifier)
#endif

namespace vsfind {
namespace {

render::Picture picture_of(std::initializer_list<Pose> poses, std::uint64_t seed) {
  render::Scene scene;
  for (const Pose& pose : poses) scene.items.push_back({render::artwork(), pose});
  render::Sensor sensor;
  sensor.seed = seed;
  return render::develop(render::expose(scene, 0.7), sensor);
}

/// Allocations of the third and later searches, of one instance and of two.
long allocations(const TrainOptions& options, int threads) {
  const render::Picture training = picture_of({{319.2, 239.3, 0.0, 1.0, 1.0}}, 1);
  const auto pattern = std::make_shared<const Pattern>(train(training.view(), Mapping(), options));
  SearchOptions search;
  search.max_instances = 2;
  search.threads = threads;
  Finder finder({pattern}, search);
  const render::Picture first = picture_of({{200.0, 200.0, 12.0, 1.0, 1.0}, {440.0, 290.0, -20.0, 1.0, 1.0}}, 2);
  const render::Picture second = picture_of({{230.0, 250.0, -31.0, 1.0, 1.0}, {430.0, 210.0, 5.0, 1.0, 1.0}}, 3);
  std::size_t found = 0;
  long before = 0;
  for (int i = 0; i < 6; ++i) {
    if (i == 2) before = taken;
    found += finder.find((i % 2 == 0 ? first : second).view(), Mapping())[0].matches.size();
  }
  const long during = taken - before;
  EXPECT_EQ(found, 12U);
  return during;
}

TrainOptions options_of_the_artwork() {
  TrainOptions options;
  options.roi = {244, 174, 150, 130};
  options.angle_deg = {-45.0, 45.0};
  return options;
}

TEST(Allocation, SearchesTakeNothingFromTheHeapAfterTheFirstOnes) {
  EXPECT_EQ(allocations(options_of_the_artwork(), 1), 0);
}

TEST(Allocation, NorWithThreads) { EXPECT_EQ(allocations(options_of_the_artwork(), 2), 0); }

TEST(Allocation, NorWithEdges) {
  TrainOptions options = options_of_the_artwork();
  options.edges = true;
  EXPECT_EQ(allocations(options, 1), 0);
}

TEST(Allocation, NorWithScales) {
  TrainOptions options = options_of_the_artwork();
  options.scale_x = options.scale_y = {0.9, 1.1};
  EXPECT_EQ(allocations(options, 1), 0);
}

TEST(Allocation, TheCounterCounts) {
  const long before = taken;
  const auto something = std::make_unique<int>(3);
  EXPECT_EQ(*something, 3);
  EXPECT_GE(taken - before, 1);
}

}  // namespace
}  // namespace vsfind
