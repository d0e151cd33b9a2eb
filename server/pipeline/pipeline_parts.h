// The state that the parts of the pipeline share: the store, the map, and who is at work on it.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "core/clock.h"
#include "core/concurrency/executor.h"
#include "core/concurrency/mutex.h"
#include "server/ingest/scan_recorder.h"
#include "server/ingest/session_workers.h"
#include "server/map/activity.h"
#include "server/map/map_writer.h"
#include "server/map/submap_cache.h"
#include "server/pipeline_options.h"
#include "server/threads/retention_thread.h"
#include "server/threads/store_health.h"

namespace isthmus::server {

// Each member is thread safe by itself.
struct PipelineParts {
  PipelineParts(const PipelineOptions& opened_with, std::unique_ptr<storage::MapStore> opened,
                const Clock& clock_given)
      : options(opened_with),
        clock(clock_given),
        queue_room(std::make_shared<ingest::QueueRoom>(options.all_queues_bytes)),
        health(&clock, options.on_problem),
        store(WatchStore(std::move(opened), &health)),
        activity(options.observer),
        submaps(store.get(), options.submap_cache_bytes,
                [this](const SubmapId& id, const std::string& problem) {
                  activity.NoteDamage(id, problem);
                  if (options.on_problem) options.on_problem(problem);
                }),
        map(store.get(), &submaps, &activity, &clock) {}

  const PipelineOptions options;
  const Clock& clock;
  const std::shared_ptr<ingest::QueueRoom> queue_room;  // Of all sessions.
  StoreHealth health;
  const std::unique_ptr<storage::MapStore> store;  // Tells `health`.
  Activity activity;
  SubmapCache submaps;
  MapWriter map;
  ingest::SessionWorkers workers;
  std::unique_ptr<ingest::ScanRecorder> scans;
  // Held while a session comes, finishes or goes and while what a person says is stored: sessions
  // that were looked up then stay what they are.
  Mutex membership;
  // Held while an uploaded submap is taken in, which takes seconds for a large one, and while its
  // session finishes or goes; before `membership`, which it is not to hold up. Sessions share one
  // now and then.
  Mutex& UploadsOf(const SessionId& session) {
    return uploads[std::hash<std::string>()(session.value()) % uploads.size()];
  }
  std::array<Mutex, 64> uploads = {};
  std::atomic<uint64_t> submaps_coming_in = 0;  // Uploads at work.
  std::atomic<bool> shut_down = false;
  // Set before anything comes in.
  RetentionThread* retention = nullptr;
  Executor* executor = nullptr;
};

}  // namespace isthmus::server
