// The client of an Isthmus server: push a robot's scans or submaps, read the merged map.
//
//   auto client = Client::Connect({.address = "localhost:50051"});
//   auto session = (*client)->CreateSession("alice", "vlp16");
//   auto stream = (*client)->OpenScanStream(session->record.id);
//   for (...) stream->Push(stamp_ns, payload);
//   stream->Finish();
//   (*client)->ExportToFile({}, "merged.pcd");
//
// See client/examples, from one call to full control.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/library/localisation.h"
#include "client/library/options.h"
#include "client/library/stream/scan_stream.h"
#include "client/library/transfers.h"
#include "core/records/access_token.h"
#include "core/records/changed_volumes.h"
#include "core/records/event.h"
#include "core/records/list_at.h"
#include "core/records/localisation.h"
#include "core/records/map_changes.h"
#include "core/records/map_edits.h"
#include "core/records/map_graph.h"
#include "core/records/map_info.h"
#include "core/records/map_reading.h"
#include "core/records/server_status.h"
#include "core/records/session_status.h"
#include "core/records/submap_upload.h"

namespace isthmus::client {

// Thread safe. Errors carry the server's code and message (see the comments of the API), or
// Unavailable, saying which address did not answer. What may be repeated without harm is tried
// again after UNAVAILABLE, see BackoffOptions; the rest, like UndoRevision, is not repeated once it
// was sent.
class Client {
 public:
  // Asks the server for a sign of life. Unavailable if it gives none in backoff.max_attempts,
  // InvalidArgument where the address is none, or token or site hold what no header may.
  static absl::StatusOr<std::unique_ptr<Client>> Connect(ClientOptions options);
  ~Client();

  absl::StatusOr<SessionStatus> CreateSession(const std::string& robot, const std::string& sensor,
                                              const Pose& T_base_sensor = {},
                                              std::optional<OdometryMode> odometry = {});
  // With a request id of the caller's it returns the session that was opened the first time, also
  // one that is finished by now; without, a new one.
  absl::StatusOr<SessionStatus> CreateSession(SessionRequest asked);
  absl::StatusOr<SessionStatus> GetSession(const SessionId& session);
  // The same, by one attempt that takes `timeout_s` at most.
  absl::StatusOr<SessionStatus> GetSessionOnce(const SessionId& session, double timeout_s);
  absl::StatusOr<std::vector<SessionStatus>> ListSessions();  // In order of creation.
  // Waits until the session's scans are processed and its last submap is durable.
  absl::StatusOr<SessionStatus> FinishSession(const SessionId& session);
  absl::Status DeleteSession(const SessionId& session);

  // The way for scans into a session that is not finished; the client must outlive it. Continues
  // after the session's last scan. With ScanStreamOptions::spool_dir the folder must hold nothing,
  // or what is left of this very session: FailedPrecondition otherwise.
  absl::StatusOr<std::unique_ptr<ScanStream>> OpenScanStream(const SessionId& session,
                                                             const ScanStreamOptions& options = {});
  // Goes on where an earlier program stopped, however it did: the session that the spool
  // `options.spool_dir` was last opened for, numbered on after its newest scan; what the server
  // lacks is sent. The server may be out of reach. NotFound when the spool holds nothing to go on
  // with, AlreadyExists when its session was finished with all that was in it (and the spool is
  // empty now). FailedPrecondition when another program has the spool open, a newer one wrote it,
  // or the session cannot go on, see IfSessionIsGone; DataLoss when it cannot be told whose scans
  // it holds.
  absl::StatusOr<std::unique_ptr<ScanStream>> ResumeScanStream(const ScanStreamOptions& options);
  // The one call that a robot needs, at its first start and at every other: as ResumeScanStream,
  // or with a new session where there is nothing to resume, which is opened as soon as the server
  // is in reach; the request's id is the library's. FailedPrecondition when the spool is of another
  // robot.
  absl::StatusOr<std::unique_ptr<ScanStream>> OpenSpool(const SessionRequest& request,
                                                        const ScanStreamOptions& options);

  // In chunks with a checksum; durable on return. Tried again after Unavailable and DataLoss, which
  // has no effect where the submap had arrived. Goes on behind what the server has of it, also if
  // an earlier call, of this program or of one before it, was cut off.
  absl::Status UploadSubmap(const SubmapUpload& submap);

  // For robots that only want to know where they are: the map does not grow. What the server says
  // of the request comes with the first scan.
  std::unique_ptr<Localisation> OpenLocalisation(const LocalisationRequest& request,
                                                 const LocalisationOptions& options = {});

  // The server's state: process, queues, progress of each robot's scans, disk. Unimplemented if the
  // server is older than this call.
  absl::StatusOr<ServerStatus> GetStatus();
  absl::StatusOr<MapInfo> GetMapInfo();
  // The submaps of one robot, or of all robots if `robot` is empty. Indices have gaps where submaps
  // were retired.
  absl::StatusOr<ListAt<SubmapStatus>> ListSubmaps(const RobotId& robot = {});
  // The trajectory of the robot's newest session, or of a session that is named in place of a
  // robot; a session's id goes first. In the map frame it is corrected by the places of the
  // submaps, smoothly from one to the next. Segment 0: in the odom frame the last; in the map frame
  // all that are placed in one component, the lowest that has any.
  absl::StatusOr<RobotTrajectory> GetTrajectory(const RobotId& robot, TrajectoryFrame frame,
                                                uint32_t segment = 0);
  // With the submaps that carry each match if `include_edges`.
  absl::StatusOr<MatchGraph> GetMatchGraph(bool include_edges = false);
  // Holds until another decision on the pair, whatever the server computes.
  absl::StatusOr<DecidedMatch> DecideMatch(const MatchDecision& decision);
  // Between the newest sessions of two robots, or sessions that are named in place of robots.
  // FailedPrecondition, saying what is missing, while nothing connects the two.
  absl::StatusOr<RobotTransform> GetTransform(const RobotId& a, const RobotId& b);

  // The revisions of the map, the newest first; at most `limit`, 100 if that is 0.
  absl::StatusOr<std::vector<RevisionInfo>> ListRevisions(int limit = 0);
  // `to` 0: the latest. OutOfRange when `from` is older than what the server keeps.
  absl::StatusOr<RevisionDiff> DiffRevisions(int64_t from, int64_t to = 0);
  // The volumes that came and went since a time or a revision, the largest first.
  // FailedPrecondition, saying which, when nothing was in the map before or nothing came since;
  // OutOfRange as above.
  absl::StatusOr<ChangeList> FindChanges(const ChangeQuery& query);
  // Rejects the accepted matches and loop closures that the revision came of, or withdraws what was
  // given by hand; returns the revision after that. FailedPrecondition when there are none. Not
  // repeated once it was sent.
  absl::StatusOr<int64_t> UndoRevision(int64_t revision, const std::string& note = {});

  // The loop closures of one robot, or of all robots if `robot` is empty; with the submaps that
  // carry each if `include_edges`.
  absl::StatusOr<ListAt<Loop>> ListLoops(const RobotId& robot = {}, bool include_edges = false);
  // Returns the loop closure without its edges.
  absl::StatusOr<DecidedLoop> DecideLoop(const LoopDecision& decision);

  // Gives a submap its place, in place of what was given before; `given_ns` is the server's. An
  // anchor that names no session is for the newest submap of the robot's newest session;
  // FailedPrecondition when that has none yet. Not repeated then once it was sent.
  absl::StatusOr<Anchored> PutAnchor(const Anchor& anchor, const RobotId& robot = {});
  // Returns the revision after that. Not repeated once it was sent.
  absl::StatusOr<int64_t> RemoveAnchor(const SubmapId& submap);
  // The place of the anchors' frame on the Earth (MapInfo::datum says it); absent: not known any
  // more.
  absl::Status SetDatum(const std::optional<Datum>& datum);
  absl::StatusOr<ListAt<RobotAnchor>> ListAnchors();  // In order of submap.

  // Calls `chunk` until it returns false (Cancelled) or all is read; at least once, also where
  // there are no points. Goes on behind the last chunk after a lost connection; Aborted where the
  // map is another by then.
  absl::Status QueryRegion(const RegionQuery& query,
                           const std::function<bool(const RegionChunk&)>& chunk);

  // The tiles of a map at a level of detail, without their points. A map is named by a session in
  // it, or by its number (see MapName).
  absl::StatusOr<TileList> ListTiles(const MapName& map, uint32_t level = 0);
  // The points of a tile as the map is now, exactly; without them where it is of `have_version`.
  absl::StatusOr<MapTile> GetTile(const TileId& id, uint64_t have_version = 0);
  // Calls `take` from this thread, at once with what is new since `known`, everything if that says
  // nothing, and then with each change of the map and of where robots are, until it returns false
  // (OK). While it is busy changes add up to one step. Goes on after a lost connection; Unavailable
  // once the server has not answered for so many attempts. See MapMirror, which keeps a copy.
  using OnStep = std::function<bool(const MapStep& step)>;
  absl::Status WatchMap(MapMark known, uint32_t level, const OnStep& take);

  // Calls `bytes` with the file piece by piece; false stops it (Cancelled). DataLoss when size or
  // checksum differ from the server's; what was received is then worthless. Not tried again after
  // the first piece.
  absl::StatusOr<ExportSummary> Export(const ExportRequest& request,
                                       const std::function<bool(const std::string&)>& bytes);
  // Into PATH.part, renamed to PATH once complete and verified, so that PATH never holds half a
  // map; tried again after Unavailable and DataLoss. A stream ("-", /dev/stdout, a pipe, see
  // core/io/output_file.h) is written as the bytes come, and not tried again once some came.
  // `progress` receives the bytes so far. InvalidArgument where the extension of PATH belongs to
  // another format than the request's.
  absl::StatusOr<ExportSummary> ExportToFile(
      const ExportRequest& request, const std::string& path,
      const std::function<void(uint64_t)>& progress = nullptr);

  // The pose graph of a map as a g2o file, likewise.
  absl::StatusOr<ExportSummary> ExportPoseGraphToFile(const MapName& map, const std::string& path);

  // A copy of all that the server stores, as of one moment, while robots and readers go on: into
  // the new folder `folder`, which isthmus-server can serve. Until it is complete, verified and on
  // the disk it is called `folder`.part. `tokens`: with the server's tokens, where it has any; a
  // folder without tokens is open to whoever reaches the server that serves it. Tried again after
  // Unavailable and DataLoss. AlreadyExists when there is a `folder`, ResourceExhausted when a disk
  // is full.
  absl::StatusOr<Backup> BackUp(const std::string& folder,
                                const std::function<void(const BackupState&)>& progress = nullptr,
                                bool tokens = false);

  // Makes a token; its secret cannot be asked for again. Without sites: for the default site, an
  // administrator's for all. Not repeated once it was sent. This and the next two: for
  // administrators, PermissionDenied else.
  absl::StatusOr<NewAccessToken> CreateToken(const AccessToken& wanted);
  absl::StatusOr<std::vector<AccessToken>> ListTokens();  // In order of creation.
  absl::StatusOr<AccessToken> RevokeToken(const std::string& name);

  // The events of the log. At most 10,000 at a time: ask on after EventPage::up_to. This and the
  // next: for operators and administrators, PermissionDenied else; OutOfRange if the log is another
  // one than `after` came from.
  absl::StatusOr<EventPage> ListEvents(const EventQuery& query = {});
  // The events that come into the log after `query.after`, or from now on; limit and time are not
  // looked at. Calls `take` from this thread, at once and with all that comes, until it returns
  // false (OK). Goes on after a lost connection, with each event once; Unavailable once the server
  // has not answered for so many attempts. Events that are not kept any more show by first_kept.
  using OnEvents = std::function<bool(const EventPage& page)>;
  absl::Status WatchEvents(EventQuery query, const OnEvents& take);

  const std::string& address() const;

  class Link;  // The connection; private to the library.

 private:
  explicit Client(std::shared_ptr<Link> link);

  const std::shared_ptr<Link> link_;
};

}  // namespace isthmus::client
