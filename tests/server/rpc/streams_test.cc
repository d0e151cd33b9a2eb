// The parts that streams are made of: strands, timers, shares of memory, places among calls.
#include <absl/time/clock.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "api/convert/retry_after.h"
#include "server/rpc/reply.h"
#include "server/rpc/streams/byte_budget.h"
#include "server/rpc/streams/call_limits.h"
#include "server/rpc/streams/strand.h"
#include "server/rpc/streams/watchdog.h"

namespace isthmus::rpc {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(StrandTest, RunsItsTasksInOrderOneAtATimeOnManyThreads) {
  constexpr int kStrands = 5, kTasks = 200;
  std::vector<std::vector<int>> seen(kStrands);
  {
    Executor executor(4);
    std::vector<std::shared_ptr<Strand>> strands;
    strands.reserve(kStrands);
    for (int s = 0; s < kStrands; ++s) strands.push_back(std::make_shared<Strand>(&executor));
    for (int k = 0; k < kTasks; ++k) {
      for (int s = 0; s < kStrands; ++s) {
        strands[s]->Post([&seen, s, k] {
          seen[s].push_back(k);
          if (k % 50 == 7) throw std::runtime_error("that task alone");
        });
      }
    }
  }
  for (const auto& order : seen) {
    ASSERT_EQ(order.size(), static_cast<size_t>(kTasks));
    EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
  }
}

TEST(WatchdogTest, FiresOnceWhenDueAndNotWhenDisarmed) {
  Watchdog::Time now;
  Watchdog watchdog([&now] { return now; });
  int first = 0, second = 0;
  Watchdog::Timer a(&watchdog, [&] { ++first; });
  {
    Watchdog::Timer b(&watchdog, [&] { ++second; });
    a.Arm(std::chrono::milliseconds(100));
    b.Arm(std::chrono::milliseconds(50));
    now += std::chrono::milliseconds(60);
    watchdog.Check();
    EXPECT_EQ(first, 0);
    EXPECT_EQ(second, 1);
    b.Arm(std::chrono::milliseconds(10));
  }
  a.Arm(std::chrono::milliseconds(100));  // In place of the one before.
  now += std::chrono::milliseconds(60);
  watchdog.Check();
  EXPECT_EQ(first, 0);
  now += std::chrono::milliseconds(60);
  watchdog.Check();
  watchdog.Check();
  EXPECT_EQ(first, 1);
  EXPECT_EQ(second, 1);
  a.Arm(std::chrono::milliseconds(1));
  a.Disarm();
  now += std::chrono::milliseconds(60);
  watchdog.Check();
  EXPECT_EQ(first, 1);
}

TEST(ByteBudgetTest, IsGivenOutInTheOrderOfAsking) {
  ByteBudget budget(100);
  std::vector<int> woken;
  auto a = budget.Ask(80, [&] { woken.push_back(0); });
  auto b = budget.Ask(50, [&] { woken.push_back(1); });
  auto c = budget.Ask(10, [&] { woken.push_back(2); });  // It would fit, but it is not its turn.
  EXPECT_TRUE(a->granted());
  EXPECT_FALSE(b->granted());
  EXPECT_FALSE(c->granted());
  a.reset();
  EXPECT_THAT(woken, ElementsAre(1, 2));
  EXPECT_TRUE(b->granted() && c->granted());
  EXPECT_EQ(budget.used(), 60u);
}

TEST(ByteBudgetTest, WhoGoesAwayHoldsUpNobody) {
  ByteBudget budget(100);
  std::vector<int> woken;
  auto a = budget.Ask(80, [] {});
  auto b = budget.Ask(90, [&] { woken.push_back(1); });
  auto c = budget.Ask(20, [&] { woken.push_back(2); });
  b.reset();
  EXPECT_THAT(woken, ElementsAre(2));
  EXPECT_TRUE(c->granted());
}

TEST(ByteBudgetTest, MoreThanAllIsGrantedAlone) {
  ByteBudget budget(100);
  auto a = budget.Ask(1, [] {});
  auto b = budget.Ask(1000, [] {});
  EXPECT_FALSE(b->granted());
  a.reset();
  EXPECT_TRUE(b->granted());
}

CallLimitOptions FewCalls() { return {.streams = 3, .streams_per_caller = 2, .queries = 2}; }

TEST(CallLimitsTest, OfOneCallerAndOfAll) {
  CallLimits limits(FewCalls());
  auto a = limits.Enter(CallLimits::Kind::kStream, "alice");
  auto b = limits.Enter(CallLimits::Kind::kStream, "alice");
  ASSERT_TRUE(a.ok() && b.ok());
  const absl::Status third = limits.Enter(CallLimits::Kind::kStream, "alice").status();
  EXPECT_TRUE(absl::IsResourceExhausted(third));
  EXPECT_THAT(std::string(third.message()), HasSubstr("max_streams_per_caller"));
  EXPECT_EQ(convert::RetryAfter(third), std::chrono::milliseconds(1000));
  auto c = limits.Enter(CallLimits::Kind::kStream, "bob");
  ASSERT_TRUE(c.ok());
  const absl::Status full = limits.Enter(CallLimits::Kind::kStream, "carol").status();
  EXPECT_TRUE(absl::IsResourceExhausted(full));
  EXPECT_THAT(std::string(full.message()), HasSubstr("network.max_streams"));
  { const CallLimits::Ticket gone = *std::move(b); }
  EXPECT_TRUE(limits.Enter(CallLimits::Kind::kStream, "carol").ok());
}

TEST(CallLimitsTest, KindsDoNotTouchEachOtherAndTheRestIsNotLimited) {
  CallLimits limits(FewCalls());
  auto query = limits.Enter(CallLimits::Kind::kQuery, "alice");
  ASSERT_TRUE(query.ok());
  EXPECT_FALSE(limits.Enter(CallLimits::Kind::kQuery, "alice").ok())
      << "half of all are one caller's";
  EXPECT_TRUE(limits.Enter(CallLimits::Kind::kQuery, "bob").ok());
  EXPECT_TRUE(limits.Enter(CallLimits::Kind::kExport, "alice").ok());
  EXPECT_TRUE(limits.Enter(CallLimits::Kind::kList, "alice").ok());
  std::vector<CallLimits::Ticket> many;
  many.reserve(100);
  for (int i = 0; i < 100; ++i) many.push_back(*limits.Enter(CallLimits::Kind::kOther, "alice"));
}

TEST(CallLimitsTest, StopsAndIsIdleWhenAllHaveLeft) {
  CallLimits limits(FewCalls());
  auto a = limits.Enter(CallLimits::Kind::kOther, "alice");
  limits.Stop();
  EXPECT_TRUE(absl::IsUnavailable(limits.Enter(CallLimits::Kind::kOther, "alice").status()));
  EXPECT_FALSE(limits.WaitUntilIdle(absl::Now()));
  { const CallLimits::Ticket gone = *std::move(a); }
  EXPECT_TRUE(limits.WaitUntilIdle(absl::Now()));
}

TEST(MachineOfTest, IsThePeerWithoutItsPort) {
  EXPECT_EQ(MachineOf("ipv4:10.0.0.7:4711"), "ipv4:10.0.0.7");
  EXPECT_EQ(MachineOf("ipv6:%5B::1%5D:4711"), "ipv6:%5B::1%5D");
  EXPECT_EQ(MachineOf("unix:/run/isthmus"), "unix");
  EXPECT_EQ(MachineOf("inproc"), "inproc");
}

TEST(RetryAfterTest, TravelsInTheDetailsOfAStatus) {
  const absl::Status status = convert::WithRetryAfter(absl::ResourceExhaustedError("full"),
                                                      std::chrono::milliseconds(2500));
  const grpc::Status sent = ToGrpc(status);
  const absl::Status received =
      convert::WithDetails(absl::ResourceExhaustedError("full"), sent.error_details());
  EXPECT_EQ(convert::RetryAfter(received), std::chrono::milliseconds(2500));
  EXPECT_EQ(ToGrpc(absl::NotFoundError("nothing")).error_details(), "");
  EXPECT_EQ(convert::RetryAfter(convert::WithDetails(absl::OkStatus(), "\xff\x01")), std::nullopt);
}

}  // namespace
}  // namespace isthmus::rpc
