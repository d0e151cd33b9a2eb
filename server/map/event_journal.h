// The journal of events: it stores the events that belong to no change of the map, and tells its
// listeners that there are new ones.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "core/clock.h"
#include "core/concurrency/listeners.h"
#include "core/concurrency/mutex.h"
#include "core/records/event.h"
#include "server/events.h"
#include "storage/map_store.h"

namespace isthmus::server {

// Thread safe. Events that belong to a change are in its batch, and stored with it or not at all.
// All others wait here for the next write of the journal's thread; while nothing can be stored they
// go on waiting.
class EventJournal : public Events {
 public:
  using Tell = std::function<void(const Event&)>;

  // `tell`, if any, is told of each event in words, from any thread: of events in a batch once it
  // is stored, of others at once. Not of events that the server reports as problems anyhow.
  EventJournal(const Clock* clock, Tell tell) : clock_(clock), tell_(std::move(tell)) {}
  ~EventJournal() override { Stop(); }
  EventJournal(const EventJournal&) = delete;
  EventJournal& operator=(const EventJournal&) = delete;

  // All of the store's promises; notes the events of its batches. The journal writes to `store`
  // itself, and must outlive the store that it returns. Call once.
  std::unique_ptr<storage::MapStore> Watch(std::unique_ptr<storage::MapStore> store);
  // After Watch.
  void Start();
  // Stores the events that wait, if the store takes them, and drops all others from then on. The
  // store must live still.
  void Stop();

  absl::StatusOr<EventPage> List(const EventQuery& query) const override {
    return store_->ListEvents(query);
  }
  // Beyond kMaxWaitingEvents the newest are lost, and counted in an event that follows.
  void Note(Event event) override;
  uint64_t OnStored(std::function<void()> wake) override { return wakes_.Add(std::move(wake)); }
  void Forget(uint64_t handle) override { wakes_.Remove(handle); }

  // Waits until everything that was noted is stored, or cannot be at the moment.
  void WaitUntilStored() const;

  // There are new ones in the store, from any writer.
  void Wake() const { wakes_.Tell(); }
  // Notes the events of a batch that is stored.
  void NoteStored(const std::vector<Event>& events);

 private:
  void Run();
  // The events to be written next; empty: none.
  std::vector<Event> Take() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Keeps them for the next time.
  void GiveBack(std::vector<Event> events) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // True if they need not be offered again.
  bool Store(const std::vector<Event>& events);

  const Clock* const clock_;
  const Tell tell_;
  storage::MapStore* store_ = nullptr;
  mutable Mutex mutex_;
  mutable CondVar changed_;
  std::deque<Event> waiting_ ABSL_GUARDED_BY(mutex_);
  uint64_t lost_ ABSL_GUARDED_BY(mutex_) = 0;  // Lost events that no event tells of yet.
  bool is_writing_ ABSL_GUARDED_BY(mutex_) = false;
  bool is_failing_ ABSL_GUARDED_BY(mutex_) = false;  // The last attempt was in vain.
  bool is_stopped_ ABSL_GUARDED_BY(mutex_) = false;
  Listeners wakes_;
  std::thread thread_;
};

}  // namespace isthmus::server
