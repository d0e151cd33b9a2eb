#include "lab/loadgen/load_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "lab/loadgen/load_report.h"
#include "server/pipeline.h"
#include "server/rpc/server.h"
#include "storage/memory_store.h"

namespace isthmus::loadgen {
namespace {

class LoadRunTest : public testing::Test {
 protected:
  void SetUp() override {
    auto pipeline = server::Pipeline::Open({}, storage::MakeMemoryStore());
    ASSERT_TRUE(pipeline.ok()) << pipeline.status();
    pipeline_ = *std::move(pipeline);
    rpc::ServerOptions options;
    options.listen = "127.0.0.1:0";
    auto server = rpc::RpcServer::Start(pipeline_.get(), options);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    options_.server = server_->address();
    options_.robots = 2;
    options_.seconds = 0.3;
    options_.rate_hz = 100;
    options_.jitter_s = 0.001;
  }

  // Drives of 3 s at a sensor's 10 Hz, sent ten times as fast.
  static Drives Simulated() {
    const auto made = SimulateDrives(
        {.world = "museum", .sensor = "vlp16", .drives = 2, .seconds = 3, .seed = 1});
    EXPECT_TRUE(made.ok()) << made.status();
    return *made;
  }

  std::unique_ptr<server::Pipeline> pipeline_;
  std::unique_ptr<rpc::RpcServer> server_;
  LoadOptions options_;
};

TEST_F(LoadRunTest, CountsWhatRobotsReadersAndStrangersDid) {
  options_.readers = 1;
  options_.reader_period_s = 0.01;
  options_.idle = 2;
  options_.knocks_per_s = 100;
  options_.server_pid = getpid();
  const auto result = RunLoad(options_, Simulated(), [](uint64_t) { return true; });
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_TRUE(AllAnswered(*result)) << ToText(*result);
  ASSERT_EQ(result->robots.size(), 2u);
  for (const RobotResult& robot : result->robots) {
    EXPECT_EQ(robot.processed, 30u);
    EXPECT_EQ(robot.ack_ms.size(), 30u);
    EXPECT_GT(robot.cloud_bytes, 30 * 10'000u);
  }
  EXPECT_GT(result->readers.at("map state").ms.size(), 0u);
  EXPECT_GT(result->knocks, 0);
  EXPECT_GT(result->server.back().use.cpu_s, 0);
  EXPECT_EQ(pipeline_->sessions().List().size(), 4u);  // The idle ones too.
}

TEST_F(LoadRunTest, StrangersAreCountedAndHinderNobody) {
  options_.misbehaving = {
      .half_open = 3, .slow_writers = 3, .slow_readers = 2, .malformed_per_s = 200};
  const auto result = RunLoad(options_, Simulated(), [](uint64_t) { return true; });
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_TRUE(AllAnswered(*result)) << ToText(*result);
  for (const RobotResult& robot : result->robots) EXPECT_EQ(robot.processed, 30u);
  EXPECT_GT(result->misbehaving.malformed, 0);
  EXPECT_EQ(result->misbehaving.tolerated, 0);
  EXPECT_EQ(result->misbehaving.unanswered, 0);
  EXPECT_EQ(result->misbehaving.not_made, 0);
}

TEST_F(LoadRunTest, OthersBesideThemCountApart) {
  options_.dense = 1;
  options_.dense_points = 20'000;
  options_.backfill = 1;
  options_.empty = 2;
  options_.server_pid = getpid();
  const auto result = RunLoad(options_, Simulated(), [](uint64_t) { return true; });
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_TRUE(AllAnswered(*result)) << ToText(*result);
  EXPECT_EQ(result->robots.size(), 2u);
  ASSERT_EQ(result->beside.size(), 2u);
  for (const RobotResult& robot : result->beside) EXPECT_GT(robot.processed, 0u) << robot.name;
  EXPECT_GT(result->thread_cpu_s.at("ingest"), 0);
  EXPECT_EQ(pipeline_->sessions().List().size(), 6u);
}

TEST_F(LoadRunTest, AllScansComeThroughABadLink) {
  options_.link = {.delay_s = 0.002, .jitter_s = 0.002, .reset_every_s = 0.1};
  const auto result = RunLoad(options_, Simulated(), [](uint64_t) { return true; });
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_TRUE(AllAnswered(*result)) << ToText(*result);
  for (const RobotResult& robot : result->robots) {
    EXPECT_EQ(robot.processed + robot.duplicates, 30u);
  }
}

TEST_F(LoadRunTest, EndsWhenToldTo) {
  options_.seconds = 1000;
  options_.rate_hz = 1;
  int ticks = 0;
  const auto result = RunLoad(options_, Simulated(), [&](uint64_t) { return ++ticks < 1; });
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_LT(result->robots[0].pushed, 10u);
}

TEST_F(LoadRunTest, SaysThatNoServerIsThere) {
  server_->Shutdown(std::chrono::milliseconds(0));
  bool has_begun = false;
  const auto result = RunLoad(options_, Simulated(), [&](uint64_t) { return has_begun = true; });
  EXPECT_FALSE(has_begun);
  EXPECT_TRUE(absl::IsUnavailable(result.status())) << result.status();
}

TEST_F(LoadRunTest, SaysThatTheProcessIsNotThere) {
  options_.server_pid = 1 << 30;
  const auto result = RunLoad(options_, Simulated(), [](uint64_t) { return true; });
  EXPECT_TRUE(absl::IsNotFound(result.status())) << result.status();
}

}  // namespace
}  // namespace isthmus::loadgen
