// The server's status, over a socket.
#include "api/convert/status.h"
#include "tests/server/rpc/rpc_fixture.h"

namespace isthmus::rpc {
namespace {

using StatusRpcTest = RpcTest;

ServerStatus Get(Stubs& stubs) {
  v1::ServerStatus status;
  EXPECT_GRPC_OK(stubs.admin->GetStatus(NewContext().get(), v1::GetStatusRequest(), &status));
  return convert::FromMessage(status);
}

TEST_F(StatusRpcTest, TellsOfTheProcessAndOfCallsUnderWay) {
  const ServerStatus idle = Get(*stubs_);
  EXPECT_EQ(idle.version, ISTHMUS_VERSION);
  EXPECT_EQ(idle.site, "default");
  EXPECT_GT(idle.started_ns, 1'700'000'000'000'000'000);
  EXPECT_GT(idle.process.cpu_s, 0);
  EXPECT_GT(idle.process.resident_bytes, 1u << 20);
  EXPECT_GT(idle.process.threads, 3u);
  EXPECT_GT(idle.process.open_files, 3u);
  EXPECT_GT(idle.process.open_files_limit, idle.process.open_files);
  EXPECT_EQ(idle.calls.streams, 0u);
  EXPECT_EQ(idle.calls.others, 1u);  // This very call.
  EXPECT_TRUE(idle.degraded.empty());

  const std::string session = stubs_->NewSession("alice");
  const auto context = NewContext();
  const auto stream = stubs_->sessions->StreamScans(context.get());
  v1::StreamScansRequest first;
  first.set_session(session);
  first.mutable_scan()->set_sequence(1);
  stream->Write(first);
  v1::StreamScansResponse ack;
  ASSERT_TRUE(stream->Read(&ack));
  const ServerStatus busy = Get(*stubs_);
  EXPECT_EQ(busy.calls.streams, 1u);
  EXPECT_EQ(busy.started_ns, idle.started_ns);
  EXPECT_GT(busy.uptime_s, idle.uptime_s);
  stream->WritesDone();
  EXPECT_GRPC_OK(stream->Finish());
}

TEST_F(StatusRpcTest, TellsOfTheLoadAndOfWhatIsDegraded) {
  SessionLoad alice;
  alice.session = SessionId("alice-1");
  alice.robot = RobotId("alice");
  alice.waiting_scans = 1;
  alice.waiting_bytes = 2;
  alice.received_sequence = 30;
  alice.acknowledged_sequence = 20;
  alice.durable_sequence = 10;
  alice.received_ns = 3;
  alice.ack_delay_ns = 4;
  alice.oldest_unacknowledged_ns = 5;
  alice.oldest_undurable_ns = 6;
  alice.scans_processed = 7;
  alice.scans_rejected = 8;
  alice.scans_skipped = 9;
  alice.tracking = Tracking::kLost;
  alice.lost_since_ns = 11;
  alice.submaps = 12;
  alice.map_bytes = 13;
  alice.scan_bytes = 14;
  {
    MutexLock lock(&pipeline_.load_mutex);
    ServerLoad& load = pipeline_.load;
    load.now_ns = 100;
    load.sessions = {alice};
    load.waiting_scans = 101;
    load.waiting_bytes = 102;
    load.waiting_bytes_limit = 103;
    load.session_scans_limit = 104;
    load.session_bytes_limit = 105;
    load.submaps_coming_in = 106;
    load.matching = {false, 107, 108};
    load.placement_waits = load.composition_waits = load.map_is_loading = true;
    load.revision = 109;
    load.submaps = 110;
    load.composition_ms = 1.5;
    load.placement_ms = 2.5;
    load.estimation_ms = 3.5;
    load.compositions = 111;
    load.placements = 112;
    load.estimations = 113;
    load.submap_cache = {114, 115};
    load.prepared_maps = {116, 117};
    load.composed = {118, 119};
    load.disk = {120, 121, 122, 123, uint64_t{1} << 40, uint64_t{2} << 40};
    load.storage_problem = "no room";
  }
  server_->TellWebAddress("https://0.0.0.0:8443");
  const ServerStatus status = Get(*stubs_);
  EXPECT_EQ(status.web_address, "https://0.0.0.0:8443");
  const ServerLoad& load = status.load;
  EXPECT_EQ(load.now_ns, 100);
  ASSERT_EQ(load.sessions.size(), 1u);
  const SessionLoad& told = load.sessions[0];
  EXPECT_EQ(told.session, alice.session);
  EXPECT_EQ(told.robot, alice.robot);
  EXPECT_EQ(told.waiting_scans, 1u);
  EXPECT_EQ(told.waiting_bytes, 2u);
  EXPECT_EQ(told.received_sequence, 30u);
  EXPECT_EQ(told.acknowledged_sequence, 20u);
  EXPECT_EQ(told.durable_sequence, 10u);
  EXPECT_EQ(told.received_ns, 3);
  EXPECT_EQ(told.ack_delay_ns, 4);
  EXPECT_EQ(told.oldest_unacknowledged_ns, 5);
  EXPECT_EQ(told.oldest_undurable_ns, 6);
  EXPECT_EQ(told.scans_processed, 7u);
  EXPECT_EQ(told.scans_rejected, 8u);
  EXPECT_EQ(told.scans_skipped, 9u);
  EXPECT_EQ(told.tracking, Tracking::kLost);
  EXPECT_EQ(told.lost_since_ns, 11);
  EXPECT_EQ(told.submaps, 12u);
  EXPECT_EQ(told.map_bytes, 13u);
  EXPECT_EQ(told.scan_bytes, 14u);
  EXPECT_EQ(load.waiting_scans, 101u);
  EXPECT_EQ(load.waiting_bytes, 102u);
  EXPECT_EQ(load.waiting_bytes_limit, 103u);
  EXPECT_EQ(load.session_scans_limit, 104u);
  EXPECT_EQ(load.session_bytes_limit, 105u);
  EXPECT_EQ(load.submaps_coming_in, 106u);
  EXPECT_FALSE(load.matching.is_idle);
  EXPECT_EQ(load.matching.submaps, 107u);
  EXPECT_EQ(load.matching.pairs, 108u);
  EXPECT_TRUE(load.placement_waits && load.composition_waits && load.map_is_loading);
  EXPECT_EQ(load.revision, 109);
  EXPECT_EQ(load.submaps, 110u);
  EXPECT_EQ(load.composition_ms, 1.5);
  EXPECT_EQ(load.placement_ms, 2.5);
  EXPECT_EQ(load.estimation_ms, 3.5);
  EXPECT_EQ(load.compositions, 111u);
  EXPECT_EQ(load.placements, 112u);
  EXPECT_EQ(load.estimations, 113u);
  EXPECT_EQ(load.submap_cache.bytes, 114u);
  EXPECT_EQ(load.submap_cache.limit_bytes, 115u);
  EXPECT_EQ(load.prepared_maps.bytes, 116u);
  EXPECT_EQ(load.composed.limit_bytes, 119u);
  EXPECT_EQ(load.disk.used_bytes(), 120u + 121 + 122 + 123);
  EXPECT_EQ(load.disk.free_bytes, uint64_t{1} << 40);
  EXPECT_EQ(load.disk.total_bytes, uint64_t{2} << 40);
  EXPECT_EQ(load.storage_problem, "no room");
  std::string degraded;
  for (const DegradedService& one : status.degraded) degraded += one.service + " " + one.why + "\n";
  EXPECT_THAT(degraded, testing::HasSubstr("isthmus.v1.SessionService no room\n"));
  EXPECT_THAT(degraded, testing::HasSubstr("isthmus.v1.EditService no room\n"));
  EXPECT_THAT(degraded, testing::HasSubstr("isthmus.v1.MapService the map is being composed"));
}

}  // namespace
}  // namespace isthmus::rpc
