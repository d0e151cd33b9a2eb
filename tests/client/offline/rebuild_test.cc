// A map made anew from its archived scans.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "client/offline/rebuild_map.h"
#include "core/codec/payload_builder.h"
#include "lab/simulation/simulator.h"
#include "server/pipeline.h"
#include "storage/archive/scan_segment.h"
#include "tests/client/cli/program.h"

namespace isthmus::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kScans = 24;
const SessionId kAlice("alice-1"), kBob("bob-1");

server::PipelineOptions Settings(const std::string& folder, server::ArchiveMode mode) {
  server::PipelineOptions options;
  options.composition_interval_s = 0;
  options.submap.cut_scans = 6;
  options.archive.mode = mode;
  options.archive.directory = folder;
  options.archive.segment_bytes = 1 << 20;
  return options;
}

void Drive(server::Pipeline& pipeline, const simulation::Simulator& simulator, int robot,
           const std::string& name) {
  const SessionId session = pipeline.sessions().Create({RobotId(name), "vlp16"}).value().record.id;
  for (int i = 0; i < kScans; ++i) {
    const Scan scan = simulator.MakeScan(robot, i);
    ScanUpload upload{scan.sequence, scan.end_stamp_ns, codec::MakePayload(scan)};
    if (i == 7) upload.payload.data.resize(5);  // Will be rejected.
    ASSERT_TRUE(pipeline.sessions().SubmitScan(session, std::move(upload)).ok());
  }
  ASSERT_TRUE(pipeline.sessions().Finish(session).ok());
}

// Two robots, what a person said of them, and where one submap lies.
void MakeMap(const std::string& folder, server::ArchiveMode mode = server::ArchiveMode::kFull) {
  auto store = storage::OpenSqliteStore(folder);
  const auto pipeline = server::Pipeline::Open(Settings(folder, mode), *std::move(store)).value();
  simulation::Options options;
  options.robots = 2;
  options.seed = 3;
  const auto simulator = simulation::Simulator::Create(options).value();
  Drive(*pipeline, *simulator, 0, "alice");
  Drive(*pipeline, *simulator, 1, "bob");
  pipeline->WaitUntilIdle();
  MatchDecision decision;
  decision.session_a = kAlice;
  decision.session_b = kBob;
  decision.kind = ManualDecisionKind::kReject;
  decision.note = "never met";
  ASSERT_TRUE(pipeline->decisions().DecideMatch(decision).ok());
  Anchor anchor;
  anchor.submap = {kAlice, 1};
  anchor.T_map_submap = Pose(Eigen::Quaterniond::Identity(), {100, 50, 2});
  anchor.sigma_xy_m = 0.1;
  ASSERT_TRUE(pipeline->decisions().PutAnchor(anchor).ok());
}

RebuildOptions Options(const std::string& folder) {
  RebuildOptions options;
  options.from = folder + "/old";
  options.to = folder + "/new";
  options.pipeline = Settings("", server::ArchiveMode::kOff);
  return options;
}

absl::StatusOr<RebuildSummary> Rebuild(const RebuildOptions& options) {
  return RebuildMap(options, [](uint64_t, uint64_t) {});
}

std::string Segment(const std::string& folder, const SessionId& session, int number) {
  return folder + "/scans/" + session.value() + "/" + storage::SegmentName(number);
}

TEST(Rebuild, WithTheSameParametersTheMapIsTheSame) {
  const std::string folder = ScratchFolder();
  MakeMap(folder + "/old");
  RebuildOptions options = Options(folder);
  options.with_scans = true;
  uint64_t last = 0, total = 0;
  const auto summary = RebuildMap(options, [&](uint64_t done, uint64_t of) {
    last = done;
    total = of;
  });
  ASSERT_TRUE(summary.ok()) << summary.status();
  // One of each session's scans never decoded, and was not kept.
  EXPECT_EQ(last, 2u * (kScans - 1));
  EXPECT_EQ(total, 2u * (kScans - 1));
  EXPECT_EQ(summary->manual_decisions, 1u);
  EXPECT_EQ(summary->anchors, 1u);
  EXPECT_TRUE(summary->notes.empty());
  ASSERT_EQ(summary->sessions.size(), 2u);
  for (const RebuiltSession& session : summary->sessions) {
    EXPECT_EQ(session.scans, kScans - 1u);
    EXPECT_EQ(session.processed, kScans - 1u);
    EXPECT_EQ(session.missing, 1u);
    EXPECT_EQ(session.compared, kScans - 1u);
    EXPECT_EQ(session.max_m, 0);
  }

  const auto old = storage::OpenSqliteStore(options.from).value();
  const auto made = storage::OpenSqliteStore(options.to).value();
  for (const SessionId& id : {kAlice, kBob}) {
    const SessionRecord before = old->GetSession(id).value(), now = made->GetSession(id).value();
    EXPECT_EQ(now.robot, before.robot);
    EXPECT_EQ(now.created_ns, before.created_ns);
    EXPECT_EQ(now.finished_ns, before.finished_ns);
    EXPECT_EQ(now.state, SessionState::kFinished);
    const auto a = old->GetTrajectory(id).value(), b = made->GetTrajectory(id).value();
    ASSERT_EQ(a.size(), b.size());
    for (size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(a[i].sequence, b[i].sequence);
      EXPECT_EQ(a[i].stamp_ns, b[i].stamp_ns);
      EXPECT_EQ(a[i].submap_index, b[i].submap_index);
      EXPECT_TRUE(a[i].T_odom_sensor.Matrix() == b[i].T_odom_sensor.Matrix()) << i;
    }
  }
  const std::vector<ManualDecision> manual_decisions = made->ListManualDecisions().value();
  ASSERT_EQ(manual_decisions.size(), 1u);
  EXPECT_EQ(manual_decisions[0].note, "never met");
  const std::vector<Anchor> anchors = made->ListAnchors().value();
  ASSERT_EQ(anchors.size(), 1u);
  EXPECT_EQ(anchors[0].submap, (SubmapId{kAlice, 1}));
  EXPECT_LT((anchors[0].T_map_submap.translation() - Eigen::Vector3d(100, 50, 2)).norm(), 1e-9);
  EXPECT_EQ(fs::file_size(Segment(options.to, kAlice, 1)),
            fs::file_size(Segment(options.from, kAlice, 1)));
}

TEST(Rebuild, WithOtherParametersTheMapIsAnother) {
  const std::string folder = ScratchFolder();
  MakeMap(folder + "/old");
  RebuildOptions options = Options(folder);
  options.sessions = {kAlice};
  options.pipeline.submap.cut_scans = 4;
  options.pipeline.submap.keyframe_voxel_m = 0.5;
  options.pipeline.odometry.features.map_voxel_m = 0.3F;
  const auto summary = Rebuild(options);
  ASSERT_TRUE(summary.ok()) << summary.status();
  ASSERT_EQ(summary->sessions.size(), 1u);
  const RebuiltSession& alice = summary->sessions[0];
  EXPECT_GT(alice.submaps, 4u);
  EXPECT_GT(alice.rmse_m, 0);
  EXPECT_LT(alice.rmse_m, 0.1);
  EXPECT_EQ(summary->manual_decisions, 0u);  // The decision's pair is not there.
  EXPECT_EQ(summary->anchors, 1u);
  const auto old = storage::OpenSqliteStore(options.from).value();
  const auto made = storage::OpenSqliteStore(options.to).value();
  EXPECT_EQ(made->ListSessions()->size(), 1u);
  // The anchor is moved along the drive to where the new submap begins.
  const Anchor anchor = made->ListAnchors().value().at(0);
  EXPECT_NE(anchor.submap.index, 0u);
  const SubmapInfo before = old->ListSubmaps(kAlice).value().at(1);
  const SubmapInfo now = made->ListSubmaps(kAlice).value().at(anchor.submap.index);
  EXPECT_LT(std::abs(before.first_stamp_ns - now.first_stamp_ns), 300'000'000);
  EXPECT_NEAR((anchor.T_map_submap.translation() - Eigen::Vector3d(100, 50, 2)).norm(),
              (now.T_odom_submap.translation() - before.T_odom_submap.translation()).norm(), 1e-6);
}

TEST(Rebuild, RoundedScansGiveNearlyTheSameMap) {
  const std::string folder = ScratchFolder();
  MakeMap(folder + "/old", server::ArchiveMode::kRounded);
  const auto summary = Rebuild(Options(folder));
  ASSERT_TRUE(summary.ok()) << summary.status();
  for (const RebuiltSession& session : summary->sessions) {
    EXPECT_EQ(session.processed, kScans - 1u);
    EXPECT_GT(session.rmse_m, 0);
    EXPECT_LT(session.rmse_m, 0.01);
  }
}

// Its oldest scans were dropped for a quota, and a record is damaged.
TEST(Rebuild, GoesOnOverHoles) {
  const std::string folder = ScratchFolder();
  MakeMap(folder + "/old");
  ASSERT_TRUE(fs::exists(Segment(folder + "/old", kAlice, 4)));
  fs::remove(Segment(folder + "/old", kAlice, 1));
  {
    const std::string path = Segment(folder + "/old", kAlice, 3);
    std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(static_cast<std::streamoff>(storage::kSegmentHeadSize + 100));
    file.put('x').put('y');
  }
  const auto summary = Rebuild(Options(folder));
  ASSERT_TRUE(summary.ok()) << summary.status();
  const RebuiltSession& alice = summary->sessions[0];
  EXPECT_LT(alice.scans, uint64_t{kScans});
  EXPECT_GT(alice.processed, 5u);
  EXPECT_GT(alice.missing, 2u);
  EXPECT_GT(alice.compared, 5u);
  EXPECT_LT(alice.rmse_m, 0.2);
  EXPECT_EQ(summary->notes.size(), 1u);
}

TEST(Rebuild, TheNewFolderIsThereOnceItIsWhole) {
  const std::string folder = ScratchFolder();
  MakeMap(folder + "/old");
  RebuildOptions options = Options(folder);
  const std::string whole = options.to, part = whole + ".part";
  options.to += "/";
  fs::create_directories(part);
  std::ofstream(part + "/isthmus.db") << "of a program that was killed";
  uint64_t asked = 0;
  const auto summary = RebuildMap(options, [&](uint64_t, uint64_t) {
    ++asked;
    EXPECT_TRUE(fs::exists(part + "/isthmus.db"));
    EXPECT_FALSE(fs::exists(whole));
  });
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_GT(asked, 0u);
  EXPECT_FALSE(fs::exists(part));
  EXPECT_TRUE(fs::exists(whole + "/isthmus.db"));
}

TEST(Rebuild, SessionsWithoutScansComeAsTheyAre) {
  const std::string folder = ScratchFolder();
  MakeMap(folder + "/old");
  fs::remove_all(folder + "/old/scans/bob-1");
  const auto summary = Rebuild(Options(folder));
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_FALSE(summary->sessions[0].is_copied);
  EXPECT_TRUE(summary->sessions[1].is_copied);
  const auto old = storage::OpenSqliteStore(folder + "/old").value();
  const auto made = storage::OpenSqliteStore(folder + "/new").value();
  const auto before = old->ListSubmaps(kBob).value(), now = made->ListSubmaps(kBob).value();
  ASSERT_EQ(before.size(), now.size());
  for (size_t i = 0; i < now.size(); ++i) EXPECT_EQ(now[i].point_count, before[i].point_count);
  EXPECT_EQ(made->GetTrajectory(kBob)->size(), old->GetTrajectory(kBob)->size());
}

TEST(Rebuild, TheCommandSaysWhatItDidAndWhatIsWrong) {
  const std::string folder = ScratchFolder();
  const std::string old = folder + "/old", made = folder + "/new";
  EXPECT_EQ(Isthmus("rebuild " + old + " --to " + made).code, 5);  // No map there.
  MakeMap(old);
  EXPECT_EQ(Isthmus("rebuild " + old + " --to " + old).code, 5);
  EXPECT_EQ(Isthmus("rebuild " + old + " --to " + made + " --sessions carol-1").code, 6);
  EXPECT_EQ(Isthmus("rebuild " + old).code, 2);
  {
    const auto in_use = storage::OpenSqliteStore(old).value();
    EXPECT_EQ(Isthmus("rebuild " + old + " --to " + made).code, 5);
  }
  std::ofstream(folder + "/better.yaml") << "submaps:\n  cut_scans: 6\n";
  const ProgramResult result = Isthmus("rebuild " + old + " --to " + made + " --config " + folder +
                                       "/better.yaml --sessions alice-1 --json");
  ASSERT_EQ(result.code, 0) << result.err;
  const json summary = json::parse(result.out);
  EXPECT_EQ(summary["sessions"].size(), 1u);
  EXPECT_EQ(summary["sessions"][0]["session"], "alice-1");
  EXPECT_EQ(summary["sessions"][0]["scans"], kScans - 1);
  EXPECT_EQ(summary["sessions"][0]["rmse_m"], 0.0);
}

// A robot that breaks off in a museum and goes on at a campus, what a person says of its segments,
// and an anchor in the second.
void MakeMapOfTwoSegments(const std::string& folder) {
  auto store = storage::OpenSqliteStore(folder);
  const auto pipeline =
      server::Pipeline::Open(Settings(folder, server::ArchiveMode::kFull), *std::move(store))
          .value();
  const SessionId session =
      pipeline->sessions().Create({RobotId("alice"), "vlp16"}).value().record.id;
  uint64_t sequence = 0;
  for (const auto& [world, scans] : {std::pair("museum", kScans), std::pair("campus", 45)}) {
    simulation::Options options;
    options.world = world;
    options.robots = 1;
    const auto simulator = simulation::Simulator::Create(options).value();
    for (int i = 0; i < scans; ++i) {
      const Scan scan = simulator->MakeScan(0, i);
      ++sequence;
      const auto stamp_ns = static_cast<int64_t>(sequence) * 100'000'000;
      ASSERT_TRUE(pipeline->sessions()
                      .SubmitScan(session, {sequence, stamp_ns, codec::MakePayload(scan)})
                      .ok());
    }
  }
  ASSERT_TRUE(pipeline->sessions().Finish(session).ok());
  pipeline->WaitUntilIdle();
  MatchDecision decision;
  decision.session_a = session;
  decision.session_b = SegmentId(session, 2);
  decision.kind = ManualDecisionKind::kReject;
  const auto decided = pipeline->decisions().DecideMatch(decision);
  ASSERT_TRUE(decided.ok()) << decided.status();
  Anchor anchor;
  anchor.submap = {SegmentId(session, 2), 0};
  anchor.T_map_submap = Pose(Eigen::Quaterniond::Identity(), {100, 50, 2});
  anchor.sigma_xy_m = 0.1;
  ASSERT_TRUE(pipeline->decisions().PutAnchor(anchor).ok());
}

TEST(Rebuild, MakesSegmentsAnewAndCarriesOverWhatWasSaidOfThem) {
  const std::string folder = ScratchFolder();
  MakeMapOfTwoSegments(folder + "/old");
  RebuildOptions options = Options(folder);
  options.sessions = {SegmentId(kAlice, 2)};
  EXPECT_TRUE(absl::IsNotFound(Rebuild(options).status())) << "it goes with alice-1";
  const auto summary = Rebuild(Options(folder));
  ASSERT_TRUE(summary.ok()) << summary.status();
  ASSERT_EQ(summary->sessions.size(), 1u);
  const RebuiltSession& session = summary->sessions[0];
  EXPECT_EQ(session.segments, 2u);
  EXPECT_EQ(session.max_m, 0);
  EXPECT_EQ(summary->manual_decisions, 1u);
  EXPECT_EQ(summary->anchors, 1u);
  EXPECT_TRUE(summary->notes.empty());
  const auto old = storage::OpenSqliteStore(folder + "/old").value();
  const auto made = storage::OpenSqliteStore(folder + "/new").value();
  const SessionId second("alice-1.2");
  const SessionRecord record = made->GetSession(second).value();
  EXPECT_EQ(record.first_segment, kAlice);
  EXPECT_EQ(record.state, SessionState::kFinished);
  EXPECT_EQ(record.finished_ns, old->GetSession(second)->finished_ns);
  EXPECT_EQ(made->GetTrajectory(second)->size(), old->GetTrajectory(second)->size());
  EXPECT_EQ(made->GetTrajectory(kAlice)->size() + made->GetTrajectory(second)->size(),
            session.compared);
  EXPECT_EQ(made->ListManualDecisions()->at(0).b, second);
  EXPECT_EQ(made->ListAnchors()->at(0).submap, (SubmapId{second, 0}));
}

// Without its scans a session is taken over with all its segments.
TEST(Rebuild, TakesOverSegmentsOfWhichNoScansAreKept) {
  const std::string folder = ScratchFolder();
  MakeMapOfTwoSegments(folder + "/old");
  fs::remove_all(folder + "/old/scans");
  const auto summary = Rebuild(Options(folder));
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_TRUE(summary->sessions[0].is_copied);
  EXPECT_EQ(summary->sessions[0].segments, 2u);
  EXPECT_EQ(summary->manual_decisions, 1u);
  EXPECT_EQ(summary->anchors, 1u);
  const auto old = storage::OpenSqliteStore(folder + "/old").value();
  const auto made = storage::OpenSqliteStore(folder + "/new").value();
  EXPECT_EQ(made->ListSubmaps(std::nullopt)->size(), old->ListSubmaps(std::nullopt)->size());
}

}  // namespace
}  // namespace isthmus::cli
