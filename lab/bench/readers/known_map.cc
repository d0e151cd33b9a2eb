#include "lab/bench/readers/known_map.h"

#include <absl/strings/str_format.h>

#include <memory>
#include <vector>

namespace isthmus::bench {
namespace {

constexpr int64_t kBeginNs = 1'500'000'000'000'000'000;

SessionRecord MakeSession(int number) {
  SessionRecord session;
  session.robot = RobotId(absl::StrFormat("mapper_%03d", number));
  session.id = SessionId(session.robot.value() + "-1");
  session.sensor = "vlp16";
  session.state = SessionState::kFinished;
  session.created_ns = kBeginNs + number;
  session.finished_ns = session.created_ns + 1;
  return session;
}

std::shared_ptr<const Submap> MakeSubmap(const SessionRecord& session, int index) {
  auto submap = std::make_shared<Submap>();
  submap->id = {session.id, static_cast<uint32_t>(index)};
  submap->robot = session.robot;
  submap->T_odom_submap = Pose(Eigen::Vector3d(index, 0, 0));
  submap->drift_covariance = Matrix6d::Identity() * 1e-4;
  submap->first_sequence = submap->last_sequence = static_cast<uint64_t>(index) + 1;
  submap->first_stamp_ns = submap->last_stamp_ns = session.created_ns + index;
  submap->keyframes = {{submap->first_sequence, submap->first_stamp_ns, Pose()}};
  for (int i = 0; i < 10; ++i) {
    submap->points.push_back({1.0f + 0.2f * static_cast<float>(i), 2.0f, 0.5f, 0, 0});
  }
  return submap;
}

LoopClosure MakeLoop(const SessionRecord& session, uint64_t id, int newer) {
  LoopClosure loop;
  loop.id = id;
  loop.session = session.id;
  loop.submap_b = static_cast<uint32_t>(newer);
  loop.T_a_b = Pose(Eigen::Vector3d(newer, 0, 0));
  loop.confidence = 0.9;
  loop.source = GuessSource::kOdometry;
  loop.detail = "generated";
  loop.edges = {{0, loop.submap_b, loop.T_a_b, Matrix6d::Identity() * 1e2}};
  return loop;
}

absl::Status WriteSession(const KnownMapOptions& options, int number, storage::MapStore* store) {
  const SessionRecord session = MakeSession(number);
  storage::WriteBatch batch;
  batch.sessions.push_back(session);
  for (int index = 0; index < options.submaps; ++index) {
    batch.submaps.push_back(MakeSubmap(session, index));
    const Submap& submap = *batch.submaps.back();
    batch.trajectory.push_back(
        {session.id,
         {submap.first_sequence, submap.first_stamp_ns, submap.T_odom_submap, submap.id.index}});
  }
  for (int loop = 0; loop < options.loops && loop + 2 < options.submaps; ++loop) {
    const auto id = static_cast<uint64_t>(number * options.loops + loop + 1);
    batch.loops.push_back(MakeLoop(session, id, options.submaps - 1 - loop));
  }
  return store->Write(batch);
}

// The pairs were compared without a result; those of the first session are then given by hand.
absl::Status WriteMatches(const KnownMapOptions& options, storage::MapStore* store) {
  storage::WriteBatch batch;
  for (int a = 0; a < options.sessions; ++a) {
    for (int b = a + 1; b < options.sessions; ++b) {
      Match& match = batch.matches.emplace_back();
      match.a = MakeSession(a).id;
      match.b = MakeSession(b).id;
      match.state = MatchState::kRejected;
      match.reason = MatchReason::kFreeSpace;
      match.detail = "generated: not compared";
      match.submaps_a = match.submaps_b = static_cast<uint32_t>(options.submaps);
      match.computed_ns = 2 * kBeginNs;
      if (a > 0) continue;
      ManualDecision& manual_decision = batch.manual_decisions.emplace_back();
      manual_decision.a = match.a;
      manual_decision.b = match.b;
      manual_decision.kind = ManualDecisionKind::kSet;
      manual_decision.T_a_b = Pose(Eigen::Vector3d(0, 5.0 * b, 0));
      manual_decision.note = "generated";
      manual_decision.given_ns = kBeginNs;
    }
  }
  return store->Write(batch);
}

}  // namespace

absl::Status WriteKnownMap(const KnownMapOptions& options, storage::MapStore* store) {
  for (int number = 0; number < options.sessions; ++number) {
    absl::Status status = WriteSession(options, number, store);
    if (!status.ok()) return status;
  }
  return WriteMatches(options, store);
}

}  // namespace isthmus::bench
