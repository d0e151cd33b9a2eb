#include "server/main/failed_call_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace isthmus::server {
namespace {

class FailedCallLogTest : public testing::Test {
 protected:
  void Note(const std::string& message) {
    log_.Note({.rpc = "GetSession", .status = absl::NotFoundError(message)});
  }

  ManualClock clock_;
  std::vector<std::string> lines_;
  FailedCallLog log_{
      [this](const rpc::FailedCall&, const std::string& line) { lines_.push_back(line); }, clock_};
};

TEST_F(FailedCallLogTest, WhatAClientSentForgesNoLineAndNoColour) {
  Note("no session \"a\n2026-01-01 info all is well\x1b[31m\x7f\xc2\x9b ä\"");
  ASSERT_EQ(lines_.size(), 1u);
  EXPECT_EQ(lines_[0],
            "GetSession: NOT_FOUND: no session \"a\\x0a2026-01-01 info all is "
            "well\\x1b[31m\\x7f\\xc2\\x9b ä\"");
}

TEST_F(FailedCallLogTest, ALineIsShort) {
  Note(std::string(20'000'000, '\n'));
  ASSERT_EQ(lines_.size(), 1u);
  EXPECT_LT(lines_[0].size(), 400u);
}

TEST_F(FailedCallLogTest, ManyCallsAreAFewLinesAndACount) {
  for (int i = 0; i < 10'000; ++i) Note(std::to_string(i));
  EXPECT_EQ(lines_.size(), 50u);
  clock_.Advance(1'000'000'000);
  Note("later");
  ASSERT_EQ(lines_.size(), 51u);
  EXPECT_EQ(lines_.back(), "GetSession: NOT_FOUND: later (9950 more failed calls before it)");
  for (int i = 100; i < 110; ++i) Note(std::to_string(i));
  EXPECT_EQ(lines_.size(), 55u);
  clock_.Advance(int64_t{3600} * 1'000'000'000);
  Note("later");
  EXPECT_EQ(lines_.back(), "GetSession: NOT_FOUND: later (6 more failed calls before it)");
}

TEST_F(FailedCallLogTest, TheSameIsSaidOnceAMinuteOfEachCaller) {
  for (int second = 0; second < 59; ++second) {
    Note("the disk is full");
    clock_.Advance(1'000'000'000);
  }
  EXPECT_EQ(lines_.size(), 1u);
  log_.Note(
      {.rpc = "GetSession", .status = absl::NotFoundError("the disk is full"), .token = "another"});
  EXPECT_EQ(lines_.size(), 2u);
  clock_.Advance(1'000'000'000);
  Note("the disk is full");
  ASSERT_EQ(lines_.size(), 3u);
  EXPECT_EQ(lines_.back(), "GetSession: NOT_FOUND: the disk is full");
}

}  // namespace
}  // namespace isthmus::server
