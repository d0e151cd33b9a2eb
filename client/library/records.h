// The server's answers as plain values. Frames and units are those of the API: metres, radians,
// Unix nanoseconds; T_target_source takes a point from `source` to `target`.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/library/graph_records.h"
#include "core/cloud.h"
#include "core/ids.h"
#include "core/match.h"
#include "core/point_payload.h"
#include "core/pose.h"
#include "core/revision.h"
#include "core/session.h"
#include "core/submap.h"
#include "core/trajectory.h"
#include "core/verdict.h"

namespace isthmus::client {

struct Session {
  SessionRecord record;
  uint64_t last_sequence = 0;     // Highest scan that took effect.
  uint64_t durable_sequence = 0;  // Scans up to here survive a crash of the server.
  uint64_t scans_processed = 0;   // Since the server started.
  uint64_t scans_rejected = 0;
  uint32_t submap_count = 0;
  uint64_t point_count = 0;
  double odometry_ms_mean = 0;
  double travelled_m = 0;
  std::string tracking;               // "ok", "degenerate", "lost"; empty before the first scan.
  std::string input;                  // How rings and times of its scans were found.
  std::optional<uint32_t> component;  // Absent until the session has been placed.
  std::optional<Pose> T_map_odom;     // Likewise.
  uint64_t map_bytes = 0;             // Stored of its submaps and their features.
  uint64_t scan_bytes = 0;            // Of its raw scans.
  uint64_t quota_bytes = 0;           // Of all sessions of its robot; 0: no limit.
  std::string archive_problem;        // What is missing of its raw scans, and why.
  // Of a session that a robot opened: how many segments it has so far, what became of all its
  // scans, and, while it is lost, END of the first scan since it was tracked last (else 0).
  uint32_t segments = 1;
  ScanCounts scans;
  int64_t lost_since_ns = 0;
};

struct Component {
  uint32_t component = 0;
  SessionId reference;  // Names the component's map frame.
  std::vector<SessionId> sessions;
  std::vector<RobotId> robots;
  uint64_t point_count = 0;
  Box bounds;  // Map frame; empty when there are no points.
};

struct MapInfo {
  int64_t revision = 0;
  std::vector<RobotId> robots;
  std::vector<Component> components;             // The largest first.
  bool settled = false;                          // The server has nothing left to do.
  double composition_ms = 0, estimation_ms = 0;  // Of the last one.
  double composition_max_ms = 0;                 // The longest since the server started.
  double placement_ms = 0;                       // Of the last optimisation of the submaps' poses.
  uint64_t compositions = 0, estimations = 0, placements = 0;  // Since the server started.
  uint64_t submaps = 0;                                        // In the map.
  uint64_t retired = 0;  // Replaced by newer ones of the same ground, since the server started.
  std::vector<std::string> damaged;  // Submaps that cannot be read, a sentence each.
  // Why the server cannot store what comes in at the moment; empty while it can.
  std::string storage_problem;
};

struct RobotTrajectory {
  // Those of one segment follow each other.
  struct Part {
    uint32_t segment = 1;
    size_t count = 0;
  };

  SessionId session;  // As the robot opened it.
  int64_t revision = 0;
  uint32_t component = 0;          // Of the map frame.
  Trajectory poses;                // In one frame.
  std::vector<Part> parts;         // Of `poses`.
  std::vector<uint32_t> left_out;  // Segments that are not among them.
};

enum class Frame { kOdom, kMap };

struct MatchEdge {
  Match match;
  RobotId robot_a, robot_b;
  bool in_tree = false;  // Carries a placement.
  // The person's decision on the pair: `match` is then as they want it.
  std::optional<Verdict> verdict = std::nullopt;
};

// A robot's request for a session.
struct SessionWish {
  std::string robot;
  std::string sensor;
  Pose T_base_sensor = {};
  std::string odometry = {};
};

// A person's word on a pair. Where no session is named, the robot's newest is meant.
struct MatchDecision {
  RobotId robot_a = {}, robot_b = {};
  SessionId session_a = {}, session_b = {};
  std::optional<Ruling> ruling = std::nullopt;  // Absent: withdraws what was said.
  Pose T_a_b = {};                              // For Ruling::kSet; a and b as named here.
  std::string note = {};                        // Why.
};

struct PlacedSession {
  Placement placement;
  RobotId robot;
};

struct MatchGraph {
  int64_t revision = 0;
  std::vector<MatchEdge> matches;
  std::vector<PlacedSession> placements;
};

struct RobotTransform {
  int64_t revision = 0;
  Pose T_a_b;  // b's odom frame to a's, both as at their newest submaps.
};

// The part of the merged map to read; without box and sphere everything. Map frame.
struct RegionQuery {
  std::optional<Box> box = std::nullopt;
  struct Sphere {
    Eigen::Vector3d center;
    double radius_m;
  };
  std::optional<Sphere> sphere = std::nullopt;  // Not together with a box.
  uint32_t component = 0;
  RobotId robot = {};       // Empty: all.
  double resolution_m = 0;  // One point per voxel of this size; 0: as composed.
};

struct RegionChunk {
  int64_t revision = 0;
  std::vector<RobotId> robots;  // MapPoint::robot indexes it; the same in every chunk.
  std::vector<MapPoint> points;
};

enum class ExportFormat {
  kPcdAscii,
  kPcdBinary,
  kPcdBinaryCompressed,
  kPly,
  kOctoMapBinary,  // .bt
  kOctoMapFull,    // .ot
};

struct ExportRequest {
  ExportFormat format = ExportFormat::kPcdBinaryCompressed;
  uint32_t component = 0;
  double resolution_m = 0;  // Clouds: thinning, 0 as composed. OctoMap: leaf size, 0 for 0.2 m.
};

struct ExportSummary {
  int64_t revision = 0;
  uint64_t size = 0;    // Bytes.
  uint32_t crc32c = 0;  // Of them all.
};

// A backup under way.
struct BackupState {
  double copied = 0;                    // Share of the copy that the server makes first, [0, 1].
  uint64_t bytes = 0, total_bytes = 0;  // Received; of the whole, once the copy is made.
};

// The contents of a backup.
struct Backup {
  ExportSummary file;
  int64_t sessions = 0, submaps = 0, scans = 0, points = 0;
  int64_t damaged = 0;  // Records that cannot be read.
  std::string report;   // What `isthmus-server --check` says of it.
};

// A finished submap of a robot that runs its own SLAM.
struct SubmapUpload {
  SubmapId id;  // The index-th of its session, from 0, without gaps.
  int64_t first_stamp_ns = 0, last_stamp_ns = 0;
  Pose T_odom_submap;
  // Poses of the sensor (T_submap_sensor); the cloud's field `keyframe` refers to them. May be
  // empty: then the sensor is taken to have stood at the submap's origin.
  std::vector<StampedPose> keyframes;
  PointPayload cloud;  // Submap frame; fields x, y, z at least.
};

}  // namespace isthmus::client
