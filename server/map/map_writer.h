// The one place where the map changes: stored first, then shown as a new view.
#pragma once

#include <absl/status/status.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/clock.h"
#include "core/concurrency/event_count.h"
#include "core/concurrency/mutex.h"
#include "core/map/finished_submap.h"
#include "core/records/event.h"
#include "server/map/activity.h"
#include "server/map/event_journal.h"
#include "server/map/map_edit.h"
#include "server/map/map_view.h"
#include "server/map/submap_cache.h"
#include "storage/map_follower.h"
#include "storage/map_store.h"

namespace isthmus::server {

// Decisions that a person makes at once.
struct ManualEdit {
  std::vector<ManualDecision> manual_decisions = {};
  std::vector<SessionPair> withdrawn = {};  // Their manual decisions are taken back.
  std::vector<LoopClosure> loops = {};      // As they are from now on.
  Actor by = {};
  std::optional<int64_t> undone = {};  // The revision that all this undoes.
  std::string note = {};               // A note on the undoing.
};

// Thread safe. A reader takes one pointer and never waits for a writer: the lock for it is held
// while a pointer is copied. Writers wait for the store without a lock, and for each other while a
// view is copied, some microseconds; those that change matches also while cycles are checked.
//
// Edits of different callers are stored and shown in any order: none rests on another's that is
// under way, as all of a session is handed over by one thread at a time. An edit that names a
// session that is gone by then is void.
class MapWriter {
 public:
  using View = std::shared_ptr<const MapView>;

  // `cache` is told which submaps come and go, `activity` that the map has changed, `events`, if
  // any, which matches joined and parted maps.
  MapWriter(storage::MapStore* store, SubmapCache* cache, Activity* activity, const Clock* clock,
            EventJournal* events = nullptr)
      : store_(store), cache_(cache), activity_(activity), clock_(clock), events_(events) {}

  // Told what a person who runs the server should know.
  using Note = std::function<void(const std::string& problem)>;

  // Reads everything back from the store. Call once, before any thread starts. DataLoss for
  // sessions that no store would have taken; `note` is told of other records that break such rules
  // (storage/batch_rules.h), which are left out.
  absl::Status Load(const Note& note = nullptr);

  // The newest; never null.
  View view() const;
  // Notified after every new view, and when nothing is placed any more.
  EventCount& changed() { return changed_; }

  // All that change what is placed return when the change is stored; the map is placed anew soon
  // after (WaitUntilPlaced).

  // New sessions, or known ones with other records; nothing that is placed changes. The event, if
  // any, is stored with them.
  absl::Status PutSessions(const std::vector<SessionRecord>& sessions,
                           std::optional<Event> event = {});
  // Stores a finished submap, or a checkpoint alone, and adds what it holds to its segment of the
  // session. A segment that does not exist yet is opened with it. NotFound when the session was
  // deleted meanwhile.
  absl::Status AddSubmap(const SessionId& session, const FinishedSubmap& finished);
  // Ignored when a session is gone.
  absl::Status PutMatch(const Match& match);
  // Stores a person's decisions on pairs and loop closures, all or nothing. All must exist.
  absl::Status PutDecisions(const ManualEdit& decisions);
  // New ones; gives them their ids. Ignored when the session is gone.
  absl::Status AddLoops(std::vector<LoopClosure> found);
  absl::Status PutAnchor(const Anchor& anchor, const Actor& by = {});
  absl::Status RemoveAnchor(const SubmapId& submap, const Actor& by = {});
  // Nothing that is placed changes.
  absl::Status SetDatum(const std::optional<Datum>& datum, const Actor& by = {});
  // Stores the ContentOf submaps whose rows have none; what is shown stays as it is.
  absl::Status KeepContents(std::vector<std::pair<SubmapId, uint64_t>> contents) {
    return store_->Write({.contents = std::move(contents)});
  }
  // Removes the submaps with all that hangs on them.
  absl::Status RetireSubmaps(const std::vector<SubmapId>& submaps);
  // Removes the session, all its segments, from store and map. `why`, where nobody asked for it, is
  // said in the revision's cause.
  absl::Status RemoveSession(const SessionId& session, const std::string& why = "",
                             const Actor& by = {});

  // Until the revision shows what the map says now, or nothing is placed any more.
  void WaitUntilPlaced() const;

  // For the threads that place and compose. Their results are shown by it, and not stored here.
  struct ToPlace {
    View view;
    Changes changes;  // Since the last call.
  };
  ToPlace TakeChanges();
  // Changes that were taken and came to nothing, for the next call.
  void GiveBack(Changes changes);
  void ShowPlaced(PlacedMap placed);
  void ShowComposed(std::shared_ptr<const ComposedMap> map);
  // Nothing will be placed any more.
  void EndPlacing();

  // For a map that another server writes: shows the changes that it stored. From one thread, with
  // nobody who edits.
  void ShowDelta(const storage::StoreDelta& delta);

 private:
  absl::Status CommitEdit(const MapEdit& edit);  // Stores, then shows.
  // False where it is void.
  bool ShowEdit(const MapEdit& edit) ABSL_LOCKS_EXCLUDED(matching_, editing_, mutex_);
  bool ShowPrepared(const MapEdit& edit, const PreparedEdit& prepared, std::vector<Event>* events)
      ABSL_LOCKS_EXCLUDED(editing_, mutex_);
  // True if the store has this submap, though no view shows it: an earlier attempt to add it
  // failed in between.
  bool IsWritten(const std::shared_ptr<const Submap>& submap) const;
  // The segments that the finished submap brings, as they are to be stored.
  std::vector<SessionRecord> NewSegments(const SessionId& session,
                                         const FinishedSubmap& finished) const;
  // The events with the present time.
  std::vector<Event> Stamped(std::vector<Event> events) const;
  // Gives it another pose where its own is damaged, and marks it.
  void MendPose(const Pose& instead, SubmapInfo* info);
  storage::SubmapInfos MendedSubmaps(const storage::StoreDelta& delta);
  absl::Status LoadSessions(MapView* view);
  absl::Status LoadDecisions(const Note& note, MapView* view);
  absl::Status LoadLoops(const Note& note, MapView* view);

  storage::MapStore* const store_;
  SubmapCache* const cache_;
  Activity* const activity_;
  const Clock* const clock_;
  EventJournal* const events_;
  EventCount changed_;

  Mutex matching_;  // Held while effective matches are worked out and shown.
  Mutex editing_ ABSL_ACQUIRED_AFTER(matching_);  // Held from one view to the next.
  mutable Mutex mutex_ ABSL_ACQUIRED_AFTER(editing_);
  View view_ ABSL_GUARDED_BY(mutex_) = std::make_shared<const MapView>();
  Changes changes_ ABSL_GUARDED_BY(mutex_);  // Since they were taken.
  bool placing_ ABSL_GUARDED_BY(mutex_) = true;
  // No number is given twice while a revision names it, even if its loop closure is gone: who
  // undoes that revision means the old one.
  uint64_t next_loop_ ABSL_GUARDED_BY(mutex_) = 1;
};

}  // namespace isthmus::server
