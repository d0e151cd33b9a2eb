#include "core/concurrency/executor.h"

#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <future>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
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

// A clock that tasks set forward, and a gate that holds the only thread until all is posted.
struct Turns {
  explicit Turns(int threads = 1)
      : executor(Executor::Options{.threads = threads, .now_s = [this] { return now_s.load(); }}) {
    executor.Post([this] { gate.get_future().wait(); });
  }
  // A task that takes so long and leaves its mark.
  void Post(const std::shared_ptr<Executor::Lane>& lane, char mark, double takes_s) {
    executor.Post(lane, [this, mark, takes_s] {
      order += mark;
      now_s = now_s + takes_s;
    });
  }
  std::string Run() {
    gate.set_value();
    EXPECT_TRUE(executor.WaitUntilIdle().ok());
    return order;
  }

  std::atomic<double> now_s = 0;
  std::promise<void> gate;
  std::string order;
  Executor executor;
};

TEST(ExecutorLanes, TheLeastServedComesFirst) {
  Turns turns;
  const auto long_ones = Executor::MakeLane(), short_ones = Executor::MakeLane();
  for (int i = 0; i < 4; ++i) turns.Post(long_ones, 'L', 0.04);
  for (int i = 0; i < 8; ++i) turns.Post(short_ones, 's', 0.01);
  // Four short ones for every long one.
  EXPECT_EQ(turns.Run(), "LssssLssssLL");
}

TEST(ExecutorLanes, WhatIsChargedMoreIsServedLess) {
  Turns turns;
  const auto live = Executor::MakeLane(), late = Executor::MakeLane(4);
  for (int i = 0; i < 3; ++i) turns.Post(late, 'b', 0.01);
  for (int i = 0; i < 8; ++i) turns.Post(live, 'l', 0.01);
  EXPECT_EQ(turns.Run(), "bllllbllllb");
}

TEST(ExecutorLanes, ATaskThatPostsItsSuccessorIsChargedForItself) {
  Turns turns;
  const auto greedy = Executor::MakeLane(), modest = Executor::MakeLane();
  std::function<void(int)> go_on = [&](int left) {
    turns.order += 'g';
    turns.now_s = turns.now_s + 0.015;
    if (left > 0) turns.executor.Post(greedy, [&, left] { go_on(left - 1); });
  };
  turns.executor.Post(greedy, [&] { go_on(3); });
  for (int i = 0; i < 4; ++i) turns.Post(modest, 'm', 0.01);
  EXPECT_EQ(turns.Run(), "gmmgmgmg");
}

TEST(ExecutorLanes, WhoWasIdleHasSavedUpNothing) {
  Turns turns;
  const auto busy = Executor::MakeLane(), idle = Executor::MakeLane();
  for (int i = 0; i < 6; ++i) turns.Post(busy, 'b', 0.01);
  // Comes when the busy one has had 30 ms.
  std::function<void()> come = [&] {
    for (int i = 0; i < 3; ++i) turns.Post(idle, 'i', 0.01);
  };
  turns.executor.Post(busy, come);
  for (int i = 0; i < 3; ++i) turns.Post(busy, 'b', 0.01);
  EXPECT_EQ(turns.Run(), "bbbbbbbibibi");
}

TEST(ExecutorLanes, SlowOnesLeaveAThreadToQuickOnes) {
  std::atomic<double> now_s = 0;
  Executor executor(Executor::Options{.threads = 2, .now_s = [&] { return now_s.load(); }});
  const auto slow_a = Executor::MakeLane(), slow_b = Executor::MakeLane();
  const auto quick = Executor::MakeLane();
  // Both are known to be slow, and somebody quick is about.
  for (const auto& lane : {slow_a, slow_b}) {
    executor.Post(lane, [&] { now_s = now_s + 0.5; });
    EXPECT_TRUE(executor.WaitUntilIdle().ok());
  }
  executor.Post(quick, [] {});
  EXPECT_TRUE(executor.WaitUntilIdle().ok());
  // A slow task holds a thread until the quick one is done; a second would hold the other.
  std::promise<void> quick_done;
  std::shared_future<void> done = quick_done.get_future().share();
  executor.Post(slow_a, [done] { done.wait(); });
  executor.Post(slow_b, [done] { done.wait(); });
  executor.Post(quick, [&] { quick_done.set_value(); });
  EXPECT_TRUE(executor.WaitUntilIdle().ok());
}

TEST(ExecutorLanes, SlowOnesTakeAllThreadsWhereNobodyElseIsAbout) {
  std::atomic<double> now_s = 0;
  Executor executor(Executor::Options{.threads = 2, .now_s = [&] { return now_s.load(); }});
  const auto slow_a = Executor::MakeLane(), slow_b = Executor::MakeLane();
  for (const auto& lane : {slow_a, slow_b}) {
    executor.Post(lane, [&] { now_s = now_s + 5; });
    EXPECT_TRUE(executor.WaitUntilIdle().ok());
  }
  std::promise<void> first, second;
  executor.Post(slow_a, [&] {
    first.set_value();
    second.get_future().wait();
  });
  executor.Post(slow_b, [&] {
    second.set_value();
    first.get_future().wait();
  });
  EXPECT_TRUE(executor.WaitUntilIdle().ok());
}

}  // namespace
}  // namespace isthmus
