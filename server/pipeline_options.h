// Every setting of the server that is not about the network, with its default.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "core/records/event.h"
#include "core/stage_observer.h"
#include "floam/odometry_options.h"
#include "floam/submap_builder.h"
#include "server/archive_options.h"
#include "server/composition/composer.h"
#include "server/composition/occupancy/occupancy_options.h"
#include "server/matching/loops/loop_options.h"
#include "server/matching/loops/revisits.h"
#include "server/matching/pairs/matcher_options.h"
#include "server/placement/placer.h"
#include "server/retention_options.h"

namespace isthmus::server {

struct PipelineOptions {
  // Scans of one session that may wait; the robot is slowed down when they are full.
  size_t scan_queue = 16;
  // Bytes of those, encoded, of all together; likewise. One session has an eighth of it. A small
  // scan of a session of which none waits always has room.
  size_t all_queues_bytes = size_t{512} << 20;
  // Larger scans are rejected.
  uint64_t max_scan_points = 1'000'000;
  // Scans a second of one session beyond which it is slowed down, or skips; 0: no limit.
  double max_scan_rate_hz = 0;
  // Sessions that are not finished, of one robot and of all: no more are opened.
  size_t max_open_sessions_per_robot = 100, max_open_sessions = 1000;
  // Threads that run odometry; one session uses one at a time. 0: two for each core, at least
  // four.
  int ingest_threads = 0;
  // Composition rests for so long at most, less after one that took little time. 0: it runs after
  // every change (tests, offline commands).
  double composition_interval_s = 1.0;
  // A pair is matched again when its maps have grown by this many submaps since the last attempt.
  int rematch_submaps = 1;
  // Submaps read from the store stay in memory up to this size ...
  size_t submap_cache_bytes = size_t{192} << 20;
  // ... and so do maps that were made ready for matching, but for the two at hand.
  size_t prepared_bytes = size_t{128} << 20;
  // File of the matcher's work at hand, so that a record that made the server crash twice is left
  // out; empty: none.
  std::string crash_journal = {};
  // Told, from any thread, what a person who runs the server should know; must not call the
  // pipeline.
  std::function<void(const std::string& problem)> on_problem = nullptr;
  // The same for events that are no problem of the server's, and go into its event log: a robot is
  // lost, was found, somebody rejected a match. Without their number.
  std::function<void(const Event& event)> on_event = nullptr;
  // Told the times of work; must outlive the pipeline. Null: nobody.
  StageObserver* observer = nullptr;
  floam::OdometryOptions odometry;
  floam::SubmapOptions submap;
  matching::MatcherOptions matcher;
  matching::LoopOptions loops;
  matching::RevisitOptions revisits;
  placement::PlacerOptions placer;
  composition::ComposerOptions composer;
  composition::OccupancyOptions occupancy;
  // MiB of evidence that OctoMaps are made of, kept from one export to the next.
  int octomap_cache_mb = 128;
  ArchiveOptions archive;
  RetentionOptions retention;
};

// Shares so many bytes of memory out among submaps, maps made ready for matching, and composition.
// Data that composition has no room for goes to a file in `folder`; none: to memory all the same.
inline void SetCache(size_t bytes, const std::string& folder, PipelineOptions* options) {
  options->submap_cache_bytes = bytes / 8 * 3;
  options->prepared_bytes = bytes / 8 * 2;
  options->composer.cache_bytes = bytes / 8 * 3;
  options->composer.folder = folder;
}

}  // namespace isthmus::server
