// Records that the tests of the stores write and compare.
#pragma once

#include <cmath>
#include <memory>
#include <random>
#include <string>

#include "storage/map_store.h"

namespace isthmus::storage {

inline SessionRecord MakeSession(const std::string& id, const std::string& robot = "alice") {
  SessionRecord record;
  record.id = SessionId(id);
  record.robot = RobotId(robot);
  record.sensor = "vlp16";
  record.odometry = OdometryMode::kFloam;
  record.T_base_sensor = Pose::FromXyzRpy(0.1, 0, 0.3, 0, 0.02, 0);
  record.created_ns = 1'700'000'000'123'456'789;
  return record;
}

inline Event MakeEvent(EventKind kind, int64_t time_ns) {
  Event event;
  event.time_ns = time_ns;
  event.kind = kind;
  event.text = "something happened";
  return event;
}

inline TrajectoryEntry MakeEntry(uint64_t sequence) {
  TrajectoryEntry entry;
  entry.sequence = sequence;
  entry.stamp_ns = 1'700'000'000'000'000'001 + static_cast<int64_t>(sequence) * 100'000'000;
  entry.T_odom_sensor = Pose::FromXyzRpy(0.1 * static_cast<double>(sequence), 0, 0, 0, 0, 0.3);
  entry.submap_index = static_cast<uint32_t>(sequence / 10);
  return entry;
}

// Its origin lies at (10 * index, 0, 0) of odom, turned by 0.3 rad; points within 4 m of it.
inline std::shared_ptr<Submap> MakeSubmap(const std::string& session, uint32_t index,
                                          size_t points = 600) {
  auto submap = std::make_shared<Submap>();
  submap->id = {SessionId(session), index};
  submap->robot = RobotId("alice");
  submap->T_odom_submap = Pose::FromXyzRpy(10.0 * index, 0, 0, 0, 0, 0.3);
  // The first of a session has none.
  submap->drift_covariance = 1e-4 * index * (Matrix6d::Identity() + Matrix6d::Ones());
  submap->first_sequence = 10 * index + 1;
  submap->last_sequence = 10 * index + 10;
  submap->first_stamp_ns = 1'700'000'000'000'000'001;
  submap->last_stamp_ns = 1'700'000'001'000'000'002;
  for (uint32_t k = 0; k < 3; ++k) {
    submap->keyframes.push_back({10 * index + 3 * k, 1'700'000'000'000'000'003 + k,
                                 Pose::FromXyzRpy(0.5 * k, 0.1, 0, 0.01, 0, 0.1 * k)});
  }
  std::mt19937 random(index);
  std::uniform_real_distribution<float> coordinate(-4, 4);
  for (size_t i = 0; i < points; ++i) {
    submap->points.push_back({coordinate(random), coordinate(random), coordinate(random),
                              static_cast<float>(i % 256), static_cast<uint16_t>(3 * i / points)});
  }
  return submap;
}

inline ManualDecision MakeManualDecision(const std::string& a, const std::string& b) {
  return {SessionId(a),
          SessionId(b),
          ManualDecisionKind::kReject,
          Pose::FromXyzRpy(1, 2, 3, 0.1, 0, -2),
          "the halls differ",
          1'700'000'000'000'000'123};
}

inline SubmapEdge MakeEdge(uint32_t a, uint32_t b) {
  SubmapEdge edge;
  edge.submap_a = a;
  edge.submap_b = b;
  edge.T_a_b = Pose::FromXyzRpy(a, b, 3, 0.1, 0.2, -0.3);
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 6; ++column) {
      edge.information(row, column) = 1000 * (row == column) + 10 * (row + column) + 1.5;
    }
  }
  return edge;
}

// A loop closure of submaps 0 and 5, with an edge between 2 and 7 beside theirs.
inline LoopClosure MakeLoop(uint64_t id, const std::string& session) {
  LoopClosure loop;
  loop.id = id;
  loop.session = SessionId(session);
  loop.submap_a = 0;
  loop.submap_b = 5;
  loop.T_a_b = Pose::FromXyzRpy(1, 2, 3, 0.1, 0.2, 0.3);
  loop.confidence = 0.75;
  loop.overlap = 0.5;
  loop.residual_m = 0.02;
  loop.free_space = 0.01;
  loop.comparisons = 99999;
  loop.source = GuessSource::kPlaces;
  loop.detail = "The robot came back to the gate.";
  loop.computed_ns = 1'700'000'000'000'000'042;
  loop.edges = {MakeEdge(0, 5), MakeEdge(2, 7)};
  loop.note = "seen by hand";
  return loop;
}

inline Anchor MakeAnchor(const std::string& session, uint32_t index) {
  return {.submap = {SessionId(session), index},
          .T_map_submap = Pose::FromXyzRpy(100, 200 + index, 3, 0.1, 0, -2),
          .sigma_xy_m = 0.02,
          .sigma_z_m = 0.05,
          .sigma_deg = 0,
          .note = "the corner stone",
          .given_ns = 1'700'000'000'000'000'099};
}

inline Match MakeMatch(const std::string& a, const std::string& b) {
  Match match;
  match.a = SessionId(a);
  match.b = SessionId(b);
  match.T_a_b = Pose::FromXyzRpy(1, 2, 3, 0.1, 0.2, 0.3);
  match.state = MatchState::kAmbiguous;
  match.reason = MatchReason::kCycle;
  match.detail = "Two rooms look alike.";
  match.confidence = 0.25;
  match.overlap = 0.5;
  match.inliers = 1234;
  match.residual_m = 0.02;
  match.free_space = 0.01;
  match.comparisons = 99999;
  match.runner_up = 0.02;
  match.matcher = GuessSource::kBirdsEye;
  match.submaps_a = 3;
  match.submaps_b = 4;
  match.computed_ns = 1'700'000'000'000'000'042;
  match.stages = {{"birds_eye", 12.5}, {"vgicp", 3.25}};
  match.inlier_ratio = 0.7;
  match.shared_area_m2 = 321.5;
  match.observability = 0.08;
  match.odometry_residual = 1.25;
  match.candidates = 17;
  match.edges = {MakeEdge(0, 5), MakeEdge(2, 7)};
  RivalMatch& rival = match.rivals.emplace_back();
  rival.T_a_b = Pose::FromXyzRpy(4, 2, 3, 0.1, 0.2, 3.3);
  rival.state = MatchState::kAmbiguous;
  rival.reason = MatchReason::kPossibleTwin;
  rival.confidence = 0.125;
  rival.matcher = GuessSource::kPlaces;
  rival.overlap = 0.4;
  rival.free_space = 0.02;
  rival.comparisons = 77777;
  rival.shared_area_m2 = 123.5;
  rival.edges = {MakeEdge(1, 6)};
  match.rivals.emplace_back().state = MatchState::kRejected;
  return match;
}

inline MapRevision MakeRevision(int64_t number) {
  MapRevision revision;
  revision.revision = number;
  revision.stamp_ns = 1'700'000'000'000'000'007;
  revision.cause = "match alice-1 ~ bob-1 accepted";
  revision.placements.push_back({SessionId("alice-1"), 0, SessionId("alice-1"), Pose()});
  revision.placements.push_back({SessionId("bob-1"), 0, SessionId("alice-1"),
                                 Pose::FromXyzRpy(static_cast<double>(number), 2, 3, 0, 0, 1)});
  return revision;
}

inline FeatureBlob MakeFeatures(const SubmapId& submap, const std::string& kind,
                                const std::string& data) {
  FeatureBlob blob;
  blob.submap = submap;
  blob.kind = kind;
  blob.data = data;
  return blob;
}

inline bool Near(const Pose& a, const Pose& b) { return Log(a.Inverse() * b).norm() < 1e-12; }

}  // namespace isthmus::storage
