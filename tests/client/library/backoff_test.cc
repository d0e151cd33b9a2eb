#include "client/library/stream/backoff.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "client/library/stream/outage.h"

namespace isthmus::client {
namespace {

std::vector<double> Delays(const BackoffOptions& options) {
  Backoff backoff(options);
  std::vector<double> delays;
  while (const std::optional<double> delay = backoff.Next()) delays.push_back(*delay);
  return delays;
}

TEST(Backoff, GrowsToItsLimitAndEnds) {
  const BackoffOptions options{
      .first_delay_s = 1, .factor = 3, .max_delay_s = 10, .jitter = 0, .max_attempts = 5};
  EXPECT_THAT(Delays(options), testing::ElementsAre(1, 3, 9, 10));
}

TEST(Backoff, OneAttemptMeansNoWaiting) { EXPECT_TRUE(Delays({.max_attempts = 1}).empty()); }

TEST(Backoff, GoesRoundAllWaysBeforeItWaits) {
  Backoff backoff({.first_delay_s = 1, .factor = 3, .jitter = 0, .max_attempts = 3}, 2);
  std::vector<double> delays;
  while (const std::optional<double> delay = backoff.Next()) delays.push_back(*delay);
  EXPECT_THAT(delays, testing::ElementsAre(0, 1, 0, 3, 0));
}

TEST(Backoff, JitterOnlyShortensAndDiffersBetweenRobots) {
  BackoffOptions options{
      .first_delay_s = 1, .factor = 1, .max_delay_s = 1, .jitter = 0.4, .max_attempts = 100};
  options.seed = 1;
  const std::vector<double> a = Delays(options);
  EXPECT_THAT(a, testing::Each(testing::AllOf(testing::Ge(0.6), testing::Le(1.0))));
  options.seed = 2;
  EXPECT_NE(a, Delays(options));
}

TEST(Backoff, BeginsAnewAfterASuccess) {
  Backoff backoff({.first_delay_s = 1, .factor = 2, .jitter = 0, .max_attempts = 3});
  EXPECT_EQ(backoff.Next(), 1);
  EXPECT_EQ(backoff.Next(), 2);
  backoff.Reset();
  EXPECT_EQ(backoff.Next(), 1);
}

TEST(Outage, EachReasonIsToldOnce) {
  Outage outage;
  EXPECT_EQ(outage.Ended(1), "");
  EXPECT_EQ(outage.Failed(absl::UnavailableError("no route"), 10),
            "interrupted, trying again: no route");
  for (int i = 0; i < 9; ++i) {
    EXPECT_EQ(outage.Failed(absl::UnavailableError("refused"), 11 + i), "");
  }
  EXPECT_EQ(outage.Failed(absl::ResourceExhaustedError("the disk is full"), 20),
            "interrupted, trying again: the disk is full");
  EXPECT_EQ(outage.Failed(absl::ResourceExhaustedError("the disk is full"), 21), "");
  EXPECT_EQ(outage.Ended(22.5), "goes on after 12.5 s, attempt 12");
  EXPECT_EQ(outage.Ended(23), "");
  EXPECT_EQ(outage.Failed(absl::UnavailableError("no route"), 30),
            "interrupted, trying again: no route");
}

}  // namespace
}  // namespace isthmus::client
