// The state that the parts of the pipeline share: the store, the map, and all at work on it.
#pragma once

#include <absl/status/status.h>

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
#include "server/map/event_journal.h"
#include "server/map/map_writer.h"
#include "server/map/submap_cache.h"
#include "server/pipeline_options.h"
#include "server/threads/retention_thread.h"
#include "server/threads/store_health.h"

namespace isthmus::server {

// Each member is thread safe by itself.
struct PipelineParts {
  PipelineParts(const PipelineOptions& opened_with, std::unique_ptr<storage::MapStore> opened,
                const Clock& clock_given, std::function<absl::Status()> takes_changes)
      : options(opened_with),
        clock(clock_given),
        check_takes_changes(std::move(takes_changes)),
        queue_room(std::make_shared<ingest::QueueRoom>(options.all_queues_bytes)),
        events(&clock, options.on_event),
        health(&clock, [this](bool fails, const std::string& news) { NoteHealth(fails, news); }),
        store(WatchStore(events.Watch(std::move(opened)), &health)),
        activity(options.observer),
        submaps(store.get(), options.submap_cache_bytes,
                [this](const SubmapId& id, const std::string& problem) {
                  activity.NoteDamage(id, problem);
                  if (options.on_problem) options.on_problem(problem);
                }),
        map(store.get(), &submaps, &activity, &clock, &events) {}

  const PipelineOptions options;
  const Clock& clock;
  const std::function<absl::Status()> check_takes_changes;  // As Pipeline::CheckTakesChanges.
  const std::shared_ptr<ingest::QueueRoom> queue_room;      // Shared by all sessions.
  // Its thread uses the store: stopped before that goes. Its writes say nothing of the health: a
  // full disk may have room for an event, and none for a submap.
  EventJournal events;
  StoreHealth health;
  const std::unique_ptr<storage::MapStore> store;  // Tells `health` and `events`.
  Activity activity;
  SubmapCache submaps;
  MapWriter map;
  ingest::SessionWorkers workers;
  std::unique_ptr<ingest::ScanRecorder> scans;
  // Held while a session comes, finishes or goes and while a person's edit is stored: sessions that
  // were looked up then stay what they are.
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
  void NoteHealth(bool fails, const std::string& news) {
    if (options.on_problem) options.on_problem(news);
    Event event;
    event.kind = fails ? EventKind::kStorageFailed : EventKind::kStorageWorks;
    event.text = news;
    events.Note(std::move(event));
  }
  // Set before anything comes in.
  RetentionThread* retention = nullptr;
  Executor* executor = nullptr;
  Executor* storing = nullptr;
};

}  // namespace isthmus::server
