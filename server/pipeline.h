// The pipeline that wires stages, queues and threads together: the whole server but its network
// skin.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <memory>
#include <string>
#include <vector>

#include "core/clock.h"
#include "core/map/map_name.h"
#include "core/records/localisation.h"
#include "core/records/map_info.h"
#include "core/records/robot_place.h"
#include "core/records/server_load.h"
#include "core/scan_upload.h"
#include "server/decisions.h"
#include "server/events.h"
#include "server/map_feed.h"
#include "server/map_reader.h"
#include "server/pipeline_options.h"
#include "server/sessions.h"
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
// several segments the last. Where a session may be named too, its id goes first.
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

  // These live as long as the pipeline. A replica's refuse every change; a session that its
  // sessions do not know may be new, and is Unavailable in place of NotFound, so that its robot
  // asks on; an event is not noted there, as the log is the other server's.
  virtual Sessions& sessions() = 0;
  virtual Decisions& decisions() = 0;
  virtual Events& events() = 0;
  virtual const MapReader& reader() const = 0;
  virtual MapFeed& feed() = 0;

  // InvalidArgument for a robot's name that is none (empty is fine), an unknown sensor or odometry;
  // NotFound: no such robot to take the map of; FailedPrecondition: no map, Unavailable: not yet.
  // In RobotPlaces and ServerLoad::localising while it lives; the pipeline must outlive it.
  virtual absl::StatusOr<std::unique_ptr<RobotLocaliser>> OpenLocaliser(
      const LocalisationRequest& request) = 0;

  virtual MapInfo GetMapInfo() = 0;
  // Cheap, so that it may be asked every second: reads nothing of the store, walks no folders, and
  // takes no lock that work is done under.
  virtual ServerLoad GetLoad() = 0;
  // The pose graph of a map as a g2o file: submaps, odometry, matches and loop closures with
  // those set aside left out. Comments name what the numbers stand for. NotFound for a map that
  // does not exist.
  virtual absl::StatusOr<std::string> ExportPoseGraph(const MapName& map) = 0;

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
