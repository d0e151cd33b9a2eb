#include "server/threads/retention_thread.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <string>
#include <vector>

namespace isthmus::server {
namespace {

TEST(RetentionThread, WhatIsThrownIsNamedAndTheNextChangeIsLookedAt) {
  std::atomic<bool> throws = true;
  std::vector<std::string> problems;
  RetentionThread::Hooks hooks;
  const SessionId session("alice-1");
  hooks.list = [&] {
    if (throws) throw std::runtime_error("a list without end");
    ingest::StoredSession stored;
    stored.session = session;
    return std::vector{stored};
  };
  hooks.map_bytes = [](const SessionId&) { return 7; };
  hooks.scan_bytes = [](const SessionId&) { return 0; };
  hooks.act = [](const ingest::RetentionAction&) { return absl::OkStatus(); };
  hooks.on_problem = [&](const std::string& problem) { problems.push_back(problem); };
  RetentionThread retention({}, &Clock::System(), hooks);
  retention.Start();
  retention.NoteChange(session);
  retention.WaitUntilIdle();
  ASSERT_EQ(problems.size(), 2u);
  EXPECT_THAT(problems[1], ::testing::HasSubstr("a list without end"));
  throws = false;
  retention.NoteChange(session);
  retention.WaitUntilIdle();
  EXPECT_EQ(problems.size(), 2u);
  EXPECT_EQ(retention.MapBytes(session), 7u);
}

}  // namespace
}  // namespace isthmus::server
