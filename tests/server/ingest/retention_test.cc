// The decision which parts of robots' sessions to delete.
#include "server/ingest/retention.h"

#include <gtest/gtest.h>

namespace isthmus::ingest {
namespace {

using Kind = RetentionAction::Kind;

constexpr int64_t kDay = int64_t{86'400} * 1'000'000'000;
constexpr int64_t kNow = 100 * kDay;
const RobotId kAlice("alice"), kBob("bob");

StoredSession Finished(const std::string& id, const RobotId& robot, double days_ago,
                       uint64_t map_bytes = 0, uint64_t scan_bytes = 0) {
  const auto finished_ns = kNow - static_cast<int64_t>(days_ago * kDay);
  return {SessionId(id), robot, true, finished_ns - 1000, finished_ns, map_bytes, scan_bytes};
}

StoredSession Active(const std::string& id, const RobotId& robot, uint64_t map_bytes = 0,
                     uint64_t scan_bytes = 0) {
  return {SessionId(id), robot, false, 5, 0, map_bytes, scan_bytes};
}

server::RetentionOptions Quota(uint64_t bytes, server::OverQuota over) {
  server::RetentionOptions options;
  options.limits.quota_bytes = bytes;
  options.over_quota = over;
  return options;
}

std::vector<std::string> Text(const RetentionPlan& plan) {
  std::vector<std::string> text;
  for (const RetentionAction& action : plan.actions) {
    text.push_back(action.kind == Kind::kDropScans
                       ? action.session.value() + ": scans " + std::to_string(action.bytes)
                       : action.session.value() + ": all");
    EXPECT_FALSE(action.why.empty());
  }
  return text;
}

using Lines = std::vector<std::string>;

TEST(RetentionTest, WithoutLimitsEverythingStays) {
  const auto plan = PlanRetention({Finished("alice-1", kAlice, 99, 1u << 30, 1u << 30)}, {}, kNow);
  EXPECT_TRUE(plan.actions.empty());
  EXPECT_TRUE(plan.refused.empty());
}

TEST(RetentionTest, FinishedSessionsGoWhenTheyAreTooOld) {
  server::RetentionOptions options;
  options.limits.max_age_days = 10;
  const auto plan =
      PlanRetention({Finished("alice-1", kAlice, 10.5), Finished("alice-2", kAlice, 9.5),
                     Finished("bob-1", kBob, 50), Active("bob-2", kBob)},
                    options, kNow);
  EXPECT_EQ(Text(plan), (Lines{"alice-1: all", "bob-1: all"}));
  EXPECT_NE(plan.actions[0].why.find("10 days"), std::string::npos);
}

TEST(RetentionTest, NothingIsTooOldWhenTheClockWasSetBack) {
  server::RetentionOptions options;
  options.limits.max_age_days = 1;
  EXPECT_TRUE(PlanRetention({Finished("alice-1", kAlice, -300)}, options, kNow).actions.empty());
}

TEST(RetentionTest, RefusingDeletesNothing) {
  const auto plan =
      PlanRetention({Finished("alice-1", kAlice, 3, 600, 600), Active("bob-1", kBob, 900, 100)},
                    Quota(1000, server::OverQuota::kRefuse), kNow);
  EXPECT_TRUE(plan.actions.empty());
  ASSERT_EQ(plan.refused.size(), 1u);
  EXPECT_EQ(plan.refused.begin()->first, kAlice);
  EXPECT_NE(plan.refused.at(kAlice).find("retention.quota_bytes"), std::string::npos);
}

TEST(RetentionTest, OldestScansGoFirstThenOldestMaps) {
  const std::vector<StoredSession> sessions = {
      Finished("alice-3", kAlice, 1, 100, 50), Finished("alice-1", kAlice, 3, 100, 50),
      Finished("alice-2", kAlice, 2, 100, 0), Active("alice-4", kAlice, 100, 100)};
  const auto plan = [&](uint64_t quota) {
    const auto made = PlanRetention(sessions, Quota(quota, server::OverQuota::kDropOldest), kNow);
    return std::make_pair(Text(made), made.refused.size());
  };
  EXPECT_EQ(plan(600), std::make_pair(Lines{}, size_t{0}));
  EXPECT_EQ(plan(570), std::make_pair(Lines{"alice-1: scans 30"}, size_t{0}));
  EXPECT_EQ(plan(530), std::make_pair(Lines{"alice-1: scans 50", "alice-3: scans 20"}, size_t{0}));
  EXPECT_EQ(
      plan(499),
      std::make_pair(Lines{"alice-1: scans 50", "alice-3: scans 50", "alice-1: all"}, size_t{0}));
  EXPECT_EQ(plan(399).first,
            (Lines{"alice-1: scans 50", "alice-3: scans 50", "alice-1: all", "alice-2: all"}));
  // A session at work is never touched: the robot is refused instead.
  EXPECT_EQ(plan(199), std::make_pair(Lines{"alice-1: scans 50", "alice-3: scans 50",
                                            "alice-1: all", "alice-2: all", "alice-3: all"},
                                      size_t{1}));
  EXPECT_EQ(plan(200).second, 0u);
}

TEST(RetentionTest, WhatGoesForItsAgeCountsNoMore) {
  server::RetentionOptions options = Quota(100, server::OverQuota::kDropOldest);
  options.limits.max_age_days = 10;
  const auto plan =
      PlanRetention({Finished("alice-1", kAlice, 20, 900, 900), Finished("alice-2", kAlice, 1, 90)},
                    options, kNow);
  EXPECT_EQ(Text(plan), (Lines{"alice-1: all"}));
  EXPECT_TRUE(plan.refused.empty());
}

TEST(RetentionTest, RobotsHaveLimitsOfTheirOwn) {
  server::RetentionOptions options = Quota(100, server::OverQuota::kRefuse);
  options.limits.max_age_days = 1;
  options.robots[kBob] = {0, 0};
  const auto plan = PlanRetention(
      {Active("alice-1", kAlice, 200), Active("bob-2", kBob, 200), Finished("bob-1", kBob, 50)},
      options, kNow);
  EXPECT_TRUE(plan.actions.empty());
  ASSERT_EQ(plan.refused.size(), 1u);
  EXPECT_TRUE(plan.refused.contains(kAlice));
}

TEST(RetentionTest, TheQuotaOfAllRobotsHoldsWhateverTheirOwnAre) {
  server::RetentionOptions options = Quota(100, server::OverQuota::kRefuse);
  options.total_quota_bytes = 250;
  const std::vector<StoredSession> sessions = {Finished("alice-1", kAlice, 3, 90),
                                               Finished("bob-1", kBob, 2, 90),
                                               Active("carol-1", RobotId("carol"), 90)};
  EXPECT_NE(PlanRetention(sessions, options, kNow).all_refused.find("total_quota_bytes"),
            std::string::npos);
  EXPECT_TRUE(PlanRetention(sessions, options, kNow).refused.empty());
  options.over_quota = server::OverQuota::kDropOldest;
  const RetentionPlan plan = PlanRetention(sessions, options, kNow);
  EXPECT_EQ(Text(plan), (Lines{"alice-1: all"}));
  EXPECT_EQ(plan.all_refused, "");
  options.total_quota_bytes = 270;
  EXPECT_TRUE(PlanRetention(sessions, options, kNow).actions.empty());
}

}  // namespace
}  // namespace isthmus::ingest
