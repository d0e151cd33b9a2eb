// The pipeline that wires stages, queues and threads together: the whole server but its network
// skin.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/anchor.h"
#include "core/clock.h"
#include "core/composed_map.h"
#include "core/loop_closure.h"
#include "core/match.h"
#include "core/revision.h"
#include "core/scan_upload.h"
#include "core/session.h"
#include "core/submap.h"
#include "core/trajectory.h"
#include "core/verdict.h"
#include "server/pipeline_options.h"
#include "storage/map_store.h"

namespace isthmus::server {

using isthmus::AckSink;
using isthmus::ScanAck;
using isthmus::ScanOutcome;
using isthmus::ScanUpload;

// A robot's request for a session.
struct SessionRequest {
  RobotId robot = {};
  std::string sensor = {};    // Name of a sensor model, e.g. "vlp16".
  std::string odometry = {};  // "continuous", "floam" or "aloam"; empty: PipelineOptions::odometry.
  Pose T_base_sensor = {};
  // Chosen by the client: asking again with the same one, for the same robot, returns the session
  // that was opened the first time. At most 64 characters; empty: a new session whatever was.
  std::string request_id = {};
};

struct SessionStatus {
  SessionRecord record;
  // Of a session that a robot opened, all but the submaps, points and the placement are of all its
  // segments; those of a later segment are its own or empty.
  uint64_t last_sequence = 0;  // Highest that took effect.
  uint64_t durable_sequence = 0;
  uint64_t scans_processed = 0;  // Since the server started.
  uint64_t scans_rejected = 0;
  uint32_t submap_count = 0;
  uint64_t point_count = 0;
  double odometry_ms_mean = 0;  // Per scan, decoding apart.
  double travelled_m = 0;
  std::string tracking;  // "ok", "degenerate", "lost"; empty before the first scan.
  std::string input;     // How rings and times of its scans were found; empty before the first.
  std::optional<Placement> placement;
  uint64_t map_bytes = 0;    // Stored of its submaps and features, as counted last.
  uint64_t scan_bytes = 0;   // Of its raw scans.
  uint64_t quota_bytes = 0;  // Of all sessions of its robot; 0: no limit.
  // The raw scans that are missing, and why; empty while all are kept, or none are to be.
  std::string archive_problem = {};
  uint32_t segments = 1;      // How many there are so far.
  ScanCounts scans = {};      // From the first scan on.
  int64_t lost_since_ns = 0;  // END of the first scan since it was tracked last; 0: it is.
};

struct ComponentInfo {
  uint32_t component = 0;
  SessionId reference;
  std::vector<SessionId> sessions;
  uint64_t point_count = 0;
  Box bounds;  // Map frame.
};

struct MapInfo {
  int64_t revision = 0;
  std::vector<RobotId> robots;
  std::vector<ComponentInfo> components;
  bool settled = false;           // Nothing is queued: no scan, submap, estimation or composition.
  double composition_ms = 0;      // Last composition of the global map, wall time.
  double composition_max_ms = 0;  // The longest since the server started.
  double estimation_ms = 0;       // Last round of transform estimation, wall time.
  double placement_ms = 0;        // Last optimisation of the submaps' poses, wall time.
  uint64_t compositions = 0, estimations = 0, placements = 0;
  uint64_t submaps = 0;  // In the map.
  uint64_t retired = 0;  // Since the server started.
  // Submaps that were found damaged since the server started, in the store's words: they are left
  // out of the map, the rest is served.
  std::vector<std::string> damaged;
  // Why what comes in cannot be stored at the moment, for people; empty while it can. Nothing is
  // acknowledged as durable meanwhile, readers are served, and it ends by itself.
  std::string storage_problem = {};
};

struct SubmapStatus {
  SubmapInfo info;
  // Its place, once it has one.
  std::optional<uint32_t> component;
  Pose T_map_submap;
};

enum class TrajectoryFrame { kOdom, kMap };

struct RobotTrajectory {
  // Those of one segment follow each other.
  struct Part {
    uint32_t segment = 1;
    size_t count = 0;
  };

  SessionId session;  // The robot's newest, as it was opened.
  int64_t revision = 0;
  uint32_t component = 0;
  Trajectory poses;              // T_odom_sensor or T_map_sensor, in one frame, in order of time.
  std::vector<Part> parts = {};  // Of `poses`.
  std::vector<uint32_t> left_out = {};  // Segments that are not among them.
};

struct MatchGraphView {
  int64_t revision = 0;
  std::vector<SessionId> nodes;
  std::vector<Match> matches;                         // Each under what a person said of its pair.
  std::vector<Verdict> verdicts;                      // What was said.
  std::vector<std::pair<SessionId, SessionId>> tree;  // Edges that carry the placements.
  std::vector<Placement> placements;
};

struct LoopStatus {
  LoopClosure loop;
  // The number of its edges that the map agrees with; those it does not were set aside as outliers.
  uint32_t edges_used = 0;
};

// The changes of the map from one revision to another.
struct RevisionDiff {
  int64_t from = 0, to = 0;
  std::vector<SubmapMove> moves;  // In order of submap, each once; those that came back left out.
  std::vector<RevisionInfo> revisions;  // After `from` up to `to`, the newest first.
};

// A person's word on a loop closure.
struct LoopDecision {
  uint64_t id = 0;
  bool rejected = true;   // False: it counts again.
  std::string note = {};  // At most 1000 characters.
};

struct RobotTransform {
  int64_t revision = 0;
  Pose T_a_b;  // b's odom frame to a's, both as at their newest submaps.
};

// A person's word on a pair. Where no session is named, the robot's newest is meant.
struct MatchDecision {
  RobotId robot_a = {}, robot_b = {};
  SessionId session_a = {}, session_b = {};
  std::optional<Ruling> ruling = {};  // Absent: what was said is withdrawn, the computed holds.
  Pose T_a_b = {};                    // For Ruling::kSet: b's odom frame to a's, as named here.
  std::string note = {};              // Why; at most 1000 characters.
};

enum class ExportFormat {
  kPcdAscii,
  kPcdBinary,
  kPcdBinaryCompressed,
  kPly,
  kOctoMapBinary,  // .bt
  kOctoMapFull,    // .ot
};

// Thread safe. A robot is named wherever a person asks; its newest session answers, where that has
// several segments the last. A later segment of a session is opened, finished and deleted with the
// session; to ask that of it alone is FailedPrecondition.
class Pipeline {
 public:
  // Takes up what the store holds: sessions, submaps, matches and the latest revision.
  static absl::StatusOr<std::unique_ptr<Pipeline>> Open(const PipelineOptions& options,
                                                        std::unique_ptr<storage::MapStore> store,
                                                        const Clock& clock = Clock::System());
  // Shutdown(), then joins every thread.
  virtual ~Pipeline() = default;

  // InvalidArgument for a robot name that is empty, longer than 64 or not of [A-Za-z0-9_.-], an
  // unknown sensor or an unknown odometry, or too long a request id. This, SubmitScan and
  // AddSubmap: ResourceExhausted while the robot is above its quota (RetentionOptions); the message
  // says what to do.
  virtual absl::StatusOr<SessionStatus> CreateSession(const SessionRequest& request) = 0;
  virtual absl::StatusOr<SessionStatus> GetSession(const SessionId& session) = 0;
  virtual std::vector<SessionStatus> ListSessions() = 0;
  // Waits for queued scans, cuts and stores the last submap. Finishing twice is no error.
  virtual absl::StatusOr<SessionStatus> FinishSession(const SessionId& session) = 0;
  // The session and all that came of it leave the map.
  virtual absl::Status DeleteSession(const SessionId& session) = 0;

  // Sets the sink of the session's acks from now on; replaces an earlier sink. A null sink drops
  // them. NotFound for an unknown session, FailedPrecondition for a finished one.
  virtual absl::Status SetAckSink(const SessionId& session, AckSink sink) = 0;
  // Queues a scan; its ack follows. Waits while the session's queue is full, so that the robot is
  // slowed down and nothing is dropped. Unavailable while shutting down. OutOfRange, and nothing
  // queued, when `sequence` leaves a gap; the message names the expected one.
  virtual absl::Status SubmitScan(const SessionId& session, ScanUpload scan) = 0;
  // A finished submap from a robot with its own SLAM; durable on return. Its session must have no
  // scans. The submap's id.index must be the next of the session (OutOfRange otherwise), or repeat
  // a stored one with equal content (OK, no effect) or not (AlreadyExists).
  virtual absl::StatusOr<SubmapInfo> AddSubmap(Submap submap) = 0;

  virtual MapInfo GetMapInfo() = 0;
  // The submaps of every session of the robot; of all robots if absent. NotFound for an unknown
  // robot.
  virtual absl::StatusOr<std::vector<SubmapStatus>> ListSubmaps(
      const std::optional<RobotId>& robot) = 0;
  // In the map frame poses follow the submaps, smoothly from one to the next; behind the newest
  // submap its T_map_odom holds. Segment 0: in the odom frame the last; in the map frame all that
  // are placed in one component, the lowest that has any. NotFound for an unknown robot or segment;
  // FailedPrecondition when frame is kMap and what was asked for has not been placed yet (nothing
  // stored of it).
  virtual absl::StatusOr<RobotTrajectory> GetTrajectory(const RobotId& robot, TrajectoryFrame frame,
                                                        uint32_t segment) = 0;
  absl::StatusOr<RobotTrajectory> GetTrajectory(const RobotId& robot, TrajectoryFrame frame) {
    return GetTrajectory(robot, frame, 0);
  }
  virtual MatchGraphView GetMatchGraph() = 0;
  // Durable on return; holds until another decision on the pair, whatever is computed. Returns the
  // match as it counts from now on (of state kNotYet when nothing is known of the pair). NotFound
  // for an unknown robot or session, InvalidArgument for a pair of one session, a transform that is
  // not finite or too long a note, FailedPrecondition to accept where nothing was found.
  virtual absl::StatusOr<Match> DecideMatch(const MatchDecision& decision) = 0;

  // Loop closures within sessions of the robot; of all robots when absent. NotFound for an unknown
  // robot.
  virtual absl::StatusOr<std::vector<LoopStatus>> ListLoops(
      const std::optional<RobotId>& robot) = 0;
  // Durable on return, with the map placed anew. NotFound for an unknown loop closure,
  // InvalidArgument for too long a note.
  virtual absl::StatusOr<LoopStatus> DecideLoop(const LoopDecision& decision) = 0;

  // Gives a submap its place, or another one. Durable on return, with the map placed anew; returns
  // its revision. NotFound for a submap that is not in the map, InvalidArgument for numbers that
  // are not finite, beyond kMaxAnchorM or no positive sigma.
  virtual absl::StatusOr<int64_t> PutAnchor(Anchor anchor) = 0;
  // NotFound when the submap has none.
  virtual absl::StatusOr<int64_t> RemoveAnchor(const SubmapId& submap) = 0;
  virtual std::vector<Anchor> ListAnchors() = 0;

  // The newest at most `limit`, the newest first.
  virtual absl::StatusOr<std::vector<RevisionInfo>> ListRevisions(int limit) = 0;
  // `to` 0: the latest. OutOfRange when `from` is older than what is kept; NotFound for one that
  // does not exist yet; InvalidArgument when from > to.
  virtual absl::StatusOr<RevisionDiff> DiffRevisions(int64_t from, int64_t to) = 0;
  // Rejects, by hand, the accepted matches and loop closures that the revision came of; a transform
  // that was given by hand is withdrawn, so that what is computed counts again. Returns the
  // revision after that. NotFound for one that is not kept; FailedPrecondition when none of what
  // made it is accepted: a revision that new submaps or an anchor made cannot be undone so.
  virtual absl::StatusOr<int64_t> UndoRevision(int64_t revision, const std::string& note) = 0;
  // The pose graph of a component as a g2o file: submaps, odometry, matches and loop closures with
  // those set aside left out. Comments name what the numbers stand for. NotFound for a component
  // that does not exist.
  virtual absl::StatusOr<std::string> ExportPoseGraph(uint32_t component) = 0;

  // NotFound for an unknown robot; FailedPrecondition when no accepted match connects them; the
  // message says what the best match lacks.
  virtual absl::StatusOr<RobotTransform> GetTransform(const RobotId& a, const RobotId& b) = 0;
  // The newest composed map; empty map of revision 0 before the first.
  virtual std::shared_ptr<const ComposedMap> GetMap() = 0;
  // Streams the file. NotFound for a component that does not exist.
  virtual absl::Status ExportMap(ExportFormat format, const Region& region,
                                 double octomap_resolution_m,
                                 const std::function<bool(const std::string&)>& sink) = 0;

  // Waits until MapInfo::settled holds, estimation of everything new included.
  virtual void WaitUntilIdle() = 0;
  // Stops taking scans, finishes those that were acknowledged or queued, cuts and stores the
  // unfinished submaps. Idempotent. The pair being estimated is finished; other pairs wait for the
  // next start.
  virtual void Shutdown() = 0;
};

}  // namespace isthmus::server
