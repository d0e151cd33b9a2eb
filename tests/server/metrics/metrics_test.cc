// Metrics of a server that takes scans over a socket, fetched over another: they say what was done.
#include "server/metrics/metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/stopwatch.h"
#include "tests/server/metrics/measured_server.h"

namespace isthmus::metrics {
namespace {

using testing::HasSubstr;

const char kCount[] = "isthmus_stage_duration_seconds_count";
const char kScans[] = "isthmus_scans_total";

v1::StreamScansRequest EmptyScan(uint64_t sequence) {
  v1::StreamScansRequest request = rpc::RoomScan("", sequence);
  request.mutable_scan()->mutable_cloud()->set_width(0);
  request.mutable_scan()->mutable_cloud()->clear_data();
  return request;
}

TEST(MetricsTest, EveryScanIsCountedOnceAtEveryStageThatItGoesThrough) {
  MeasuredServer server;
  server.Drive("alice", 30);
  const std::string bob = server.stubs->NewSession("bob");
  std::vector<v1::StreamScansRequest> sent;
  for (uint64_t i = 1; i <= 20; ++i) sent.push_back(rpc::RoomScan("", i));
  sent.push_back(EmptyScan(21));
  sent.push_back(sent[4]);
  EXPECT_EQ(server.Stream(bob, sent).size(), sent.size());
  server.Finish(bob);
  server.pipeline->WaitUntilIdle();

  const Scrape scrape = server.Ask();
  EXPECT_EQ(scrape.Sum(kScans, {{"robot", "alice"}}), 30);
  EXPECT_EQ(scrape.Sum(kScans, {{"robot", "bob"}, {"outcome", "processed"}}), 20);
  EXPECT_EQ(scrape.Sum(kScans, {{"robot", "bob"}, {"outcome", "rejected"}}), 1);
  EXPECT_EQ(scrape.Sum(kScans, {{"robot", "bob"}, {"outcome", "duplicate"}}), 1);
  EXPECT_EQ(scrape.Sum(kScans, {{"site", "default"}}), 52);

  const auto count = [&](const char* stage) { return scrape.Sum(kCount, {{"stage", stage}}); };
  EXPECT_EQ(count("decode"), 51);
  EXPECT_GE(count("odometry"), 50);  // The empty scan too, if it comes so far.
  EXPECT_LE(count("odometry"), 51);
  EXPECT_EQ(count("acknowledge"), 52);
  EXPECT_EQ(count("durable"), 51);
  EXPECT_EQ(count("store"), static_cast<double>(server.pipeline->GetMapInfo().submaps));
  for (const char* stage : {"match", "placement", "composition"})
    EXPECT_GE(count(stage), 1) << stage;
}

TEST(MetricsTest, TimesArePlausible) {
  MeasuredServer server;
  server.Drive("alice", 30);
  const Scrape scrape = server.Ask();
  const auto sum = [&](const char* stage) {
    return scrape.Sum("isthmus_stage_duration_seconds_sum", {{"stage", stage}});
  };
  EXPECT_GT(sum("decode"), 0);
  EXPECT_GT(sum("odometry"), sum("decode"));
  // A scan has waited, and was decoded and tracked, before it is acknowledged, and is stored later.
  EXPECT_GT(sum("acknowledge"), sum("odometry"));
  EXPECT_GT(sum("durable"), sum("acknowledge"));
  EXPECT_LT(sum("acknowledge"), 30 * 60);
  // The last bucket holds all.
  EXPECT_EQ(
      scrape.Sum("isthmus_stage_duration_seconds_bucket", {{"stage", "odometry"}, {"le", "+Inf"}}),
      30);
}

TEST(MetricsTest, CallsAreCountedByMethodAndByHowTheyEnd) {
  MeasuredServer server;
  server.Drive("alice", 3);
  v1::GetSessionRequest request;
  request.set_session("nobody-1");
  v1::Session session;
  for (int i = 0; i < 2; ++i) {
    EXPECT_GRPC_ERROR(
        server.stubs->sessions->GetSession(rpc::NewContext().get(), request, &session), NOT_FOUND,
        "nobody-1");
  }
  const Scrape scrape = server.Ask();
  const auto count = [&](const char* method, const char* code) {
    return scrape.Sum("isthmus_rpc_duration_seconds_count", {{"method", method}, {"code", code}});
  };
  EXPECT_EQ(count("CreateSession", "OK"), 1);
  EXPECT_EQ(count("StreamScans", "OK"), 1);
  EXPECT_EQ(count("GetSession", "NOT_FOUND"), 2);
  EXPECT_TRUE(std::isnan(count("GetSession", "OK")));
}

TEST(MetricsTest, RobotsBeyondTheLimitAreCountedTogether) {
  MeasuredServer server(1);
  server.Drive("alice", 3);
  server.Drive("bob", 4);
  server.Drive("carol", 5);
  const Scrape scrape = server.Ask();
  EXPECT_EQ(scrape.Sum(kScans, {{"robot", "alice"}}), 3);
  EXPECT_EQ(scrape.Sum(kScans, {{"robot", "(others)"}}), 9);
  for (const Sample& sample : scrape.samples()) {
    const auto robot = sample.labels.find("robot");
    if (robot == sample.labels.end()) continue;
    EXPECT_TRUE(robot->second == "alice" || robot->second == "(others)") << sample.name;
  }
}

TEST(MetricsTest, TheProcessIsMeasured) {
  const MeasuredServer server;
  const Scrape scrape = server.Ask();
  EXPECT_EQ(scrape.Sum("isthmus_build_info", {{"version", "1.2.3"}}), 1);
  EXPECT_GT(scrape.Sum("process_cpu_seconds_total"), 0);
  EXPECT_GT(scrape.Sum("process_resident_memory_bytes"), 1e6);
  EXPECT_GE(scrape.Sum("process_threads"), 4);
  EXPECT_GE(scrape.Sum("process_open_fds"), 4);
  EXPECT_GE(scrape.Sum("process_max_fds"), scrape.Sum("process_open_fds"));
  // This test's process started within the last day.
  const double now_s = static_cast<double>(time(nullptr));
  EXPECT_NEAR(scrape.Sum("process_start_time_seconds"), now_s, 86'400);
}

TEST(MetricsTest, OtherMachinesReachThemOnlyWhereThatIsSaid) {
  EXPECT_TRUE(CheckListening({}).ok());
  EXPECT_TRUE(CheckListening({.listen = "127.0.0.1:9464"}).ok());
  EXPECT_TRUE(CheckListening({.listen = "0.0.0.0:9464", .insecure = true}).ok());
  const absl::Status open = CheckListening({.listen = "0.0.0.0:9464"});
  EXPECT_TRUE(absl::IsFailedPrecondition(open)) << open;
  EXPECT_THAT(std::string(open.message()), HasSubstr("metrics.insecure"));
  for (const char* wrong :
       {"9464", "unix:/run/metrics", "127.0.0.1:http", "127.0.0.1:1,0.0.0.0:2"}) {
    const absl::Status status = CheckListening({.listen = wrong});
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr("metrics.listen"));
  }
  Metrics metrics({.listen = "0.0.0.0:0"}, "");
  EXPECT_TRUE(absl::IsFailedPrecondition(metrics.Serve({})));
}

}  // namespace
}  // namespace isthmus::metrics
