#include "core/concurrency/executor.h"

#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <memory>
#include <new>
#include <stdexcept>
#include <vector>

namespace isthmus {
namespace {

TEST(Executor, OfOneThreadKeepsTheOrder) {
  std::vector<int> order;
  Executor executor(1);
  for (int i = 0; i < 100; ++i) executor.Post([&order, i] { order.push_back(i); });
  EXPECT_TRUE(executor.WaitUntilIdle().ok());
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
  EXPECT_TRUE(executor.WaitUntilIdle().ok());
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
  EXPECT_TRUE(executor.WaitUntilIdle().ok());
  EXPECT_EQ(done, 60);
  EXPECT_TRUE(executor.WaitUntilIdle().ok());  // Idle already: returns.
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
  EXPECT_TRUE(executor.WaitUntilIdle().ok());
  EXPECT_TRUE(watch.expired());
}

TEST(Executor, WhatATaskThrowsEndsThatTaskAloneAndIsToldToWhoWaits) {
  Executor executor(1);
  std::atomic<int> done = 0;
  executor.Post([] { throw std::runtime_error("the first"); });
  executor.Post([] { throw std::bad_alloc(); });
  executor.Post([&] { ++done; });
  const absl::Status first = executor.WaitUntilIdle();
  EXPECT_EQ(done, 1);
  EXPECT_EQ(first.code(), absl::StatusCode::kInternal);
  EXPECT_NE(first.message().find("the first"), absl::string_view::npos) << first;
  EXPECT_TRUE(executor.WaitUntilIdle().ok()) << "told once";
  executor.Post([] { throw std::bad_alloc(); });
  EXPECT_TRUE(absl::IsResourceExhausted(executor.WaitUntilIdle()));
  executor.Post([] { throw 1; });
  EXPECT_TRUE(absl::IsInternal(executor.WaitUntilIdle()));
}

}  // namespace
}  // namespace isthmus
