#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include "app/bounded_queue.h"

namespace vsfind {
namespace {

TEST(BoundedQueue, KeepsOrderAndNeverHoldsMoreThanItsCapacity) {
  BoundedQueue<int> queue(3);
  std::atomic<int> pushed = 0;
  constexpr int count = 2000;
  std::jthread producer([&] {
    for (int i = 0; i < count; ++i) {
      ASSERT_TRUE(queue.push(i));
      ++pushed;
    }
    queue.close();
  });
  int expected = 0;
  while (const auto item = queue.pop()) {
    EXPECT_EQ(*item, expected++);
    // Those taken, those held, and none more.
    EXPECT_LE(pushed.load(), expected + 3);
  }
  EXPECT_EQ(expected, count);
}

TEST(BoundedQueue, AFullQueueMakesThePusherWait) {
  BoundedQueue<int> queue(1);
  ASSERT_TRUE(queue.push(1));
  std::atomic<bool> done = false;
  std::jthread producer([&] {
    queue.push(2);
    done = true;
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_FALSE(done);
  EXPECT_EQ(queue.pop(), 1);
  producer.join();
  EXPECT_TRUE(done);
  EXPECT_EQ(queue.pop(), 2);
}

TEST(BoundedQueue, DropsTheOldestWhereAskedTo) {
  BoundedQueue<int> queue(2);
  std::optional<int> dropped;
  ASSERT_TRUE(queue.push_dropping_oldest(1, dropped));
  ASSERT_TRUE(queue.push_dropping_oldest(2, dropped));
  EXPECT_FALSE(dropped);
  ASSERT_TRUE(queue.push_dropping_oldest(3, dropped));
  EXPECT_EQ(dropped, 1);
  EXPECT_EQ(queue.pop(), 2);
  EXPECT_EQ(queue.pop(), 3);
}

TEST(BoundedQueue, MayBeGivenMoreRoom) {
  BoundedQueue<int> queue(1);
  std::optional<int> dropped;
  ASSERT_TRUE(queue.push(1));
  std::jthread waiting([&] { EXPECT_TRUE(queue.push(2)); });
  queue.set_capacity(3);
  waiting.join();
  ASSERT_TRUE(queue.push_dropping_oldest(3, dropped));
  EXPECT_FALSE(dropped);
  ASSERT_TRUE(queue.push_dropping_oldest(4, dropped));
  EXPECT_EQ(dropped, 1);
}

TEST(BoundedQueue, CloseHandsOutTheRestAndRefusesMore) {
  BoundedQueue<int> queue(4);
  ASSERT_TRUE(queue.push(1));
  queue.close();
  EXPECT_FALSE(queue.push(2));
  std::optional<int> dropped;
  EXPECT_FALSE(queue.push_dropping_oldest(3, dropped));
  EXPECT_EQ(queue.pop(), 1);
  EXPECT_EQ(queue.pop(), std::nullopt);
}

TEST(BoundedQueue, AbortThrowsTheRestAwayAndWakesEveryone) {
  BoundedQueue<std::shared_ptr<int>> queue(1);
  const auto item = std::make_shared<int>(1);
  ASSERT_TRUE(queue.push(item));
  std::atomic<bool> refused = false;
  std::jthread producer([&] { refused = !queue.push(item); });
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  queue.abort();
  producer.join();
  EXPECT_TRUE(refused);
  EXPECT_EQ(queue.pop(), std::nullopt);
  EXPECT_EQ(item.use_count(), 1);
}

}  // namespace
}  // namespace vsfind
