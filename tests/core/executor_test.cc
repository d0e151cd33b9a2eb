#include "core/executor.h"

#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <memory>
#include <vector>

namespace isthmus {
namespace {

TEST(Executor, OfOneThreadKeepsTheOrder) {
  std::vector<int> order;
  Executor executor(1);
  for (int i = 0; i < 100; ++i) executor.Post([&order, i] { order.push_back(i); });
  executor.WaitUntilIdle();
  ASSERT_EQ(order.size(), 100u);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(order[i], i);
}

TEST(Executor, RunsTasksSideBySide) {
  Executor executor(2);
  std::promise<void> first, second;
  // Each waits for the other: one thread would never get done.
  executor.Post([&] {
    first.set_value();
    second.get_future().wait();
  });
  executor.Post([&] {
    second.set_value();
    first.get_future().wait();
  });
  executor.WaitUntilIdle();
}

TEST(Executor, WaitUntilIdleIncludesTasksOfTasks) {
  Executor executor(2);
  std::atomic<int> done = 0;
  for (int i = 0; i < 20; ++i) {
    executor.Post([&] {
      executor.Post([&] {
        executor.Post([&] { ++done; });
        ++done;
      });
      ++done;
    });
  }
  executor.WaitUntilIdle();
  EXPECT_EQ(done, 60);
  executor.WaitUntilIdle();  // Idle already: returns.
}

TEST(Executor, DestructorRunsWhatWasPosted) {
  std::atomic<int> done = 0;
  {
    Executor executor(2);
    for (int i = 0; i < 50; ++i) executor.Post([&] { ++done; });
  }
  EXPECT_EQ(done, 50);
}

TEST(Executor, LetsGoOfWhatTasksHeldBeforeItIsIdle) {
  Executor executor(1);
  auto held = std::make_shared<int>(1);
  const std::weak_ptr<int> watch = held;
  executor.Post([held = std::move(held)] {});
  executor.WaitUntilIdle();
  EXPECT_TRUE(watch.expired());
}

}  // namespace
}  // namespace isthmus
