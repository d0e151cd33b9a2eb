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

#include "core/clock.h"
#include "core/map/anchor.h"
#include "core/map/composed_map.h"
#include "core/map/revision.h"
#include "core/map/submap.h"
#include "core/records/event.h"
#include "core/records/list_at.h"
#include "core/records/localisation.h"
#include "core/records/map_edits.h"
#include "core/records/map_graph.h"
#include "core/records/map_info.h"
#include "core/records/map_reading.h"
#include "core/records/server_load.h"
#include "core/records/session_status.h"
#include "core/scan_upload.h"
#include "server/map_feed.h"
#include "server/map_reader.h"
#include "server/pipeline_options.h"
#include "storage/map_follower.h"
#include "storage/map_store.h"

namespace isthmus::server {

// A robot that is looked for in the map, and followed. Nothing of it is kept. Not thread safe.
class RobotLocaliser {
 public:
  virtual ~RobotLocaliser() = default;
  // The place at which the scan was taken. A scan that cannot be used is no error, see
  // LocalisedScan::rejected. Unavailable while shutting down, ResourceExhausted where memory ran
  // out.
  virtual absl::StatusOr<LocalisedScan> Locate(const ScanUpload& scan) = 0;
};

// The threads that PipelineOptions::ingest_threads stands for. 0: two for each core, so that a core
// is at work while a submap is waited for; four at least, as one stays for others while slow scans
// are dealt with.
int IngestThreads(int setting);

// Thread safe. A robot is named wherever a person asks; its newest session answers, where that has
// several segments the last. A later segment of a session is opened, finished and deleted with the
// session; to ask that of it alone is FailedPrecondition.
class Pipeline {
 public:
  // Takes up what the store holds: sessions, submaps, matches and the latest revision.
  static absl::StatusOr<std::unique_ptr<Pipeline>> Open(const PipelineOptions& options,
                                                        std::unique_ptr<storage::MapStore> store,
                                                        const Clock& clock = Clock::System());
  // For a map that another server has, which goes on changing it: shows what that one stores, soon
  // after, and refuses every change (CheckTakesChanges). `store` and `follower` read the same map.
  static absl::StatusOr<std::unique_ptr<Pipeline>> OpenReplica(
      const PipelineOptions& options, std::unique_ptr<storage::MapStore> store,
      std::unique_ptr<storage::MapFollower> follower, const Clock& clock = Clock::System());
  // For a process that is about to end itself: whatever a pipeline has at hand by this journal
  // (PipelineOptions::crash_journal), it is not what ended it.
  static void ClearBlame(const std::string& crash_journal);
  // Shutdown(), then joins every thread.
  virtual ~Pipeline() = default;

  // OK, or FailedPrecondition, saying whom to ask: every change ends with it in a replica.
  virtual absl::Status CheckTakesChanges() const { return absl::OkStatus(); }

  // InvalidArgument for a robot name that is empty, longer than 64 or not of [A-Za-z0-9_.-], an
  // unknown sensor or an unknown odometry, or too long a request id. This, SubmitScan and
  // AddSubmap: ResourceExhausted while the robot is above its quota (RetentionOptions); the message
  // says what to do.
  // What changes the map says who asked for it, for the event log; with each change there is a form
  // that names nobody.
  virtual absl::StatusOr<SessionStatus> CreateSession(const SessionRequest& request,
                                                      const Actor& by) = 0;
  absl::StatusOr<SessionStatus> CreateSession(const SessionRequest& request) {
    return CreateSession(request, Actor());
  }
  virtual absl::StatusOr<SessionStatus> GetSession(const SessionId& session) = 0;
  virtual std::vector<SessionStatus> ListSessions() = 0;
  // Waits for queued scans, cuts and stores the last submap. Finishing twice is no error.
  virtual absl::StatusOr<SessionStatus> FinishSession(const SessionId& session,
                                                      const Actor& by) = 0;
  absl::StatusOr<SessionStatus> FinishSession(const SessionId& session) {
    return FinishSession(session, Actor());
  }
  // The session and all that came of it leave the map.
  virtual absl::Status DeleteSession(const SessionId& session, const Actor& by) = 0;
  absl::Status DeleteSession(const SessionId& session) { return DeleteSession(session, Actor()); }

  // Sets the sink of the session's acks from now on; replaces an earlier sink. A null sink drops
  // them. NotFound for an unknown session, FailedPrecondition for a finished one.
  virtual absl::Status SetAckSink(const SessionId& session, AckSink sink) = 0;
  // Queues a scan; its ack follows. Waits while the session's queue is full, so that the robot is
  // slowed down and nothing is dropped. Unavailable while shutting down. OutOfRange, and nothing
  // queued, when `sequence` leaves a gap; the message names the expected one.
  virtual absl::Status SubmitScan(const SessionId& session, ScanUpload scan) = 0;
  // The same without waiting: false, and the scan as it was, where there is no room or the session
  // is beyond the limit on its rate. Room comes back with acks of the session and, where sessions
  // share it, of others, and that of the rate with time.
  virtual absl::StatusOr<bool> OfferScan(const SessionId& session, ScanUpload* scan) = 0;
  // A finished submap from a robot with its own SLAM; durable on return. Its session must have no
  // scans. The submap's id.index must be the next of the session (OutOfRange otherwise), or repeat
  // a stored one with equal content (OK, no effect) or not (AlreadyExists).
  virtual absl::StatusOr<SubmapInfo> AddSubmap(Submap submap) = 0;

  // InvalidArgument for a robot's name that is none (empty is fine), an unknown sensor or odometry;
  // NotFound: no such robot to take the map of; FailedPrecondition: no map, Unavailable: not yet.
  // In RobotPlaces and ServerLoad::localising while it lives; the pipeline must outlive it.
  virtual absl::StatusOr<std::unique_ptr<RobotLocaliser>> OpenLocaliser(
      const LocalisationRequest& request) = 0;

  // Both live as long as the pipeline.
  virtual const MapReader& reader() const = 0;
  virtual MapFeed& feed() = 0;
  virtual MapInfo GetMapInfo() = 0;
  // Cheap, so that it may be asked every second: reads nothing of the store, walks no folders, and
  // takes no lock that work is done under.
  virtual ServerLoad GetLoad() = 0;
  // The submaps of every session of the robot; of all robots if absent. NotFound for an unknown
  // robot.
  virtual absl::StatusOr<ListAt<SubmapStatus>> ListSubmaps(const std::optional<RobotId>& robot) = 0;
  // See MapReader::GetTrajectory.
  virtual absl::StatusOr<RobotTrajectory> GetTrajectory(const RobotId& robot, TrajectoryFrame frame,
                                                        uint32_t segment) = 0;
  absl::StatusOr<RobotTrajectory> GetTrajectory(const RobotId& robot, TrajectoryFrame frame) {
    return GetTrajectory(robot, frame, 0);
  }
  // Each match as a person's decision on its pair changes it.
  virtual MatchGraph GetMatchGraph() = 0;
  // Durable on return; holds until another decision on the pair, against all that is computed.
  // NotFound for an unknown robot or session, InvalidArgument for a pair of one session, a
  // transform that is not finite or too long a note, FailedPrecondition to accept where nothing was
  // found.
  virtual absl::StatusOr<DecidedMatch> DecideMatch(const MatchDecision& decision,
                                                   const Actor& by) = 0;
  absl::StatusOr<DecidedMatch> DecideMatch(const MatchDecision& decision) {
    return DecideMatch(decision, Actor());
  }

  // Loop closures within sessions of the robot; of all robots when absent. NotFound for an unknown
  // robot.
  virtual absl::StatusOr<ListAt<Loop>> ListLoops(const std::optional<RobotId>& robot) = 0;
  // Durable on return, with the map placed anew. NotFound for an unknown loop closure,
  // InvalidArgument for too long a note.
  virtual absl::StatusOr<DecidedLoop> DecideLoop(const LoopDecision& decision, const Actor& by) = 0;
  absl::StatusOr<DecidedLoop> DecideLoop(const LoopDecision& decision) {
    return DecideLoop(decision, Actor());
  }

  // Gives a submap its place, or another one. Durable on return, with the map placed anew; returns
  // its revision. NotFound for a submap that is not in the map, InvalidArgument for numbers that
  // are not finite, beyond kMaxAnchorM or no positive sigma.
  virtual absl::StatusOr<int64_t> PutAnchor(Anchor anchor, const Actor& by) = 0;
  absl::StatusOr<int64_t> PutAnchor(const Anchor& anchor) { return PutAnchor(anchor, Actor()); }
  // NotFound when the submap has none.
  virtual absl::StatusOr<int64_t> RemoveAnchor(const SubmapId& submap, const Actor& by) = 0;
  absl::StatusOr<int64_t> RemoveAnchor(const SubmapId& submap) {
    return RemoveAnchor(submap, Actor());
  }

  // Durable on return; absent: there is none any more. InvalidArgument as CheckDatum.
  virtual absl::Status SetDatum(std::optional<Datum> datum, const Actor& by) = 0;
  absl::Status SetDatum(std::optional<Datum> datum) { return SetDatum(datum, Actor()); }

  // Rejects, by hand, the accepted matches and loop closures that the revision came of; a transform
  // that was given by hand is withdrawn, so that the computed one counts again. Returns the
  // revision after that. NotFound for one that is not kept; FailedPrecondition when nothing that
  // made it is accepted: a revision that new submaps or an anchor made cannot be undone so.
  virtual absl::StatusOr<int64_t> UndoRevision(int64_t revision, const std::string& note,
                                               const Actor& by) = 0;
  absl::StatusOr<int64_t> UndoRevision(int64_t revision, const std::string& note) {
    return UndoRevision(revision, note, Actor());
  }
  // The pose graph of a map as a g2o file: submaps, odometry, matches and loop closures with
  // those set aside left out. Comments name what the numbers stand for. NotFound for a map that
  // does not exist.
  virtual absl::StatusOr<std::string> ExportPoseGraph(const MapName& map) = 0;

  // The newest composed map; empty map of revision 0 before the first.
  virtual std::shared_ptr<const ComposedMap> GetMap() = 0;

  // The stored part of the event log, which may lack the events of a moment ago.
  virtual absl::StatusOr<EventPage> ListEvents(const EventQuery& query) = 0;
  // An event that is none of the map's; it is in the log soon.
  virtual void NoteEvent(Event event) = 0;
  // See EventJournal.
  virtual uint64_t OnEvents(std::function<void()> wake) = 0;
  virtual void ForgetEvents(uint64_t handle) = 0;

  // Places of robots that are under way: those that map in order of their sessions, then those
  // that are localised. Cheap, as GetLoad.
  virtual std::vector<RobotPlace> RobotPlaces() = 0;

  // Waits until MapInfo::settled holds, estimation of everything new included. A replica has read
  // by then all that the store held when this was called, if it can be read.
  virtual void WaitUntilIdle() = 0;
  // Lets go of scans that wait and takes no more; does not wait. These scans are not acknowledged:
  // their robot sends them again, to the next server. For an end that cannot wait for queued scans;
  // Shutdown is to follow.
  virtual void StopTaking() = 0;
  // Stops taking scans, finishes those that were acknowledged or queued, cuts and stores the
  // unfinished submaps. Idempotent. The pair being estimated is finished; other pairs wait for the
  // next start.
  virtual void Shutdown() = 0;
};

}  // namespace isthmus::server
