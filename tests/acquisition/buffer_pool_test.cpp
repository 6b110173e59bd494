#include "acquisition/buffer_pool.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <future>
#include <limits>
#include <set>
#include <thread>
#include <type_traits>
#include <vector>

#include "acquisition/source.h"

namespace vsfind {
namespace {

using namespace std::chrono_literals;

static_assert(!std::is_copy_constructible_v<Frame> && !std::is_copy_assignable_v<Frame>);
static_assert(std::is_nothrow_move_constructible_v<Frame> && std::is_nothrow_move_assignable_v<Frame>);
static_assert(std::is_nothrow_destructible_v<Frame>);

/// Counts what comes back.
class CountingOwner final : public BufferOwner {
 public:
  explicit CountingOwner(std::vector<std::uint32_t>& returned) : returned_(returned) {}
  void give_back(std::uint32_t index) noexcept override { returned_.push_back(index); }

 private:
  std::vector<std::uint32_t>& returned_;
};

TEST(Frame, GivesItsBufferBackExactlyOnce) {
  std::vector<std::uint32_t> returned;
  const auto owner = std::make_shared<CountingOwner>(returned);
  {
    Frame first(owner, 1, {}, {});
    Frame second(owner, 2, {}, {});
    Frame moved(std::move(first));
    EXPECT_TRUE(returned.empty());
    second = std::move(moved);  // 2 goes back at once, not with the emptied frame
    EXPECT_EQ(returned, std::vector<std::uint32_t>{2});
    Frame& itself = second;
    second = std::move(itself);
    EXPECT_EQ(returned, std::vector<std::uint32_t>{2});
  }
  EXPECT_EQ(returned, (std::vector<std::uint32_t>{2, 1}));
  EXPECT_EQ(owner.use_count(), 1);
}

TEST(BufferPool, LendsTheSameMemoryAgain) {
  const auto pool = BufferPool::create(4);
  const std::byte* memory = pool->acquire(1000)->data();
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(memory) % 64, 0U);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(pool->acquire(1000)->data(), memory);
}

TEST(BufferPool, LendsDifferentBuffersAtATime) {
  const auto pool = BufferPool::create(4);
  std::vector<BufferPool::Lease> leases;
  std::set<std::byte*> memory;
  for (int i = 0; i < 4; ++i) {
    leases.push_back(*pool->acquire(100));
    memory.insert(leases.back().data());
  }
  EXPECT_EQ(memory.size(), 4U);
}

TEST(BufferPool, WaitsWhileAllAreLent) {
  const auto pool = BufferPool::create(2);
  auto first = std::make_unique<Frame>(std::move(*pool->acquire(10)).to_frame({}, {}));
  const Frame second = std::move(*pool->acquire(10)).to_frame({}, {});
  auto third = std::async(std::launch::async, [&] { return pool->acquire(10).has_value(); });
  EXPECT_EQ(third.wait_for(50ms), std::future_status::timeout);
  first.reset();
  ASSERT_EQ(third.wait_for(10s), std::future_status::ready);
  EXPECT_TRUE(third.get());
}

TEST(BufferPool, StopEndsTheWaiting) {
  const auto pool = BufferPool::create(1);
  const auto lease = pool->acquire(10);
  auto waiting = std::async(std::launch::async, [&] { return pool->acquire(10).has_value(); });
  EXPECT_EQ(waiting.wait_for(20ms), std::future_status::timeout);
  pool->stop();
  ASSERT_EQ(waiting.wait_for(10s), std::future_status::ready);
  EXPECT_FALSE(waiting.get());
  EXPECT_FALSE(pool->acquire(10).has_value());
}

TEST(BufferPool, LivesAsLongAsItsLastFrame) {
  auto pool = BufferPool::create(2);
  const std::weak_ptr<BufferPool> watched = pool;
  Frame frame = std::move(*pool->acquire(64)).to_frame({}, {});
  pool->stop();
  pool.reset();
  EXPECT_FALSE(watched.expired());
  std::thread([taken = std::move(frame)] {}).join();
  EXPECT_TRUE(watched.expired());
}

TEST(BufferPool, SurvivesAnAllocationThatFails) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers end the program at such an allocation";
#endif
  const auto pool = BufferPool::create(1);
  constexpr std::size_t impossible = std::numeric_limits<std::size_t>::max() / 4;
  EXPECT_THROW(static_cast<void>(pool->acquire(impossible)), std::bad_alloc);
  EXPECT_NE(pool->acquire(100)->data(), nullptr);
}

TEST(BufferPool, ServesManyThreads) {
  const auto pool = BufferPool::create(3);
  std::vector<std::thread> threads;
  std::atomic<int> torn = 0;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < 2000; ++i) {
        const auto lease = pool->acquire(sizeof(int));
        int* mine = reinterpret_cast<int*>(lease->data());
        *mine = t * 10000 + i;
        std::this_thread::yield();
        if (*mine != t * 10000 + i) ++torn;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(torn, 0);
}

TEST(BufferPool, RecordingsAreBoundedByMemory) {
  EXPECT_EQ(recording_buffers(1), 1024U);
  EXPECT_EQ(recording_buffers(std::size_t{1} << 20U), 256U);
  EXPECT_EQ(recording_buffers(std::size_t{1} << 31U), 8U);
}

TEST(FramesThatMayWait, AreFourOrThoseOfATenthOfASecond) {
  EXPECT_EQ(frames_that_may_wait({}), 4U);
  EXPECT_EQ(frames_that_may_wait({25, 1}), 4U);
  EXPECT_EQ(frames_that_may_wait({30'000, 1001}), 4U);
  EXPECT_EQ(frames_that_may_wait({400'000, 1000}), 40U);
  EXPECT_EQ(frames_that_may_wait({1'000'000, 1}), 64U);
}

}  // namespace
}  // namespace vsfind
