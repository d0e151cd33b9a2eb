#include "server/map/event_journal.h"

#include <absl/strings/str_cat.h>
#include <absl/time/clock.h>

#include <algorithm>
#include <string>
#include <utility>

#include "core/caught.h"
#include "core/concurrency/thread_role.h"
#include "core/plain_text.h"
#include "server/map/limits.h"
#include "storage/forwarding_store.h"

namespace isthmus::server {
namespace {

class JournaledStore : public storage::ForwardingStore {
 public:
  JournaledStore(std::unique_ptr<storage::MapStore> store, EventJournal* journal)
      : ForwardingStore(std::move(store)), journal_(*journal) {}

  absl::Status Write(const storage::WriteBatch& batch) override {
    absl::Status status = ForwardingStore::Write(batch);
    if (status.ok()) journal_.NoteStored(batch.events);
    return status;
  }
  using ForwardingStore::DeleteSession;
  absl::Status DeleteSession(const SessionId& session, const std::vector<Event>& events) override {
    absl::Status status = ForwardingStore::DeleteSession(session, events);
    if (status.ok()) journal_.NoteStored(events);
    return status;
  }

 private:
  EventJournal& journal_;
};

// True if the server's log has the same from elsewhere, as a problem or from main.
bool IsToldAnyhow(EventKind kind) {
  switch (kind) {
    case EventKind::kServerStarted:
    case EventKind::kServerStopped:
    case EventKind::kSessionExpired:
    case EventKind::kStorageFailed:
    case EventKind::kStorageWorks:
    case EventKind::kCertificateExpires:
      return true;
    default:
      return false;
  }
}

}  // namespace

std::unique_ptr<storage::MapStore> EventJournal::Watch(std::unique_ptr<storage::MapStore> store) {
  store_ = store.get();
  return std::make_unique<JournaledStore>(std::move(store), this);
}

void EventJournal::Start() {
  thread_ = std::thread([this] { Run(); });
}

void EventJournal::Stop() {
  {
    MutexLock lock(&mutex_);
    is_stopped_ = true;
    changed_.SignalAll();
  }
  if (thread_.joinable()) thread_.join();
}

void EventJournal::Note(Event event) {
  if (event.kind == EventKind::kUnknown) return;  // The store would refuse others with it.
  if (event.time_ns == 0) event.time_ns = clock_->NowNs();
  event.text = CutText(event.text, kMaxEventText);
  if (tell_ && !IsToldAnyhow(event.kind)) tell_(event);
  MutexLock lock(&mutex_);
  if (is_stopped_) return;
  if (waiting_.size() >= kMaxWaitingEvents) {
    ++lost_;
    return;
  }
  waiting_.push_back(std::move(event));
  changed_.SignalAll();
}

void EventJournal::NoteStored(const std::vector<Event>& events) {
  if (events.empty()) return;
  for (const Event& event : events) {
    if (tell_ && !IsToldAnyhow(event.kind)) tell_(event);
  }
  Wake();
}

void EventJournal::WaitUntilStored() const {
  MutexLock lock(&mutex_);
  while (!is_stopped_ && !is_failing_ && (is_writing_ || !waiting_.empty())) {
    changed_.Wait(&mutex_);
  }
}

std::vector<Event> EventJournal::Take() {
  std::vector<Event> events;
  while (!waiting_.empty() && events.size() < kMaxEventsAtOnce) {
    events.push_back(std::move(waiting_.front()));
    waiting_.pop_front();
  }
  if (!events.empty() && waiting_.empty() && lost_ > 0) {
    Event& lost = events.emplace_back();
    lost.time_ns = clock_->NowNs();
    lost.kind = EventKind::kEventsLost;
    lost.text = absl::StrCat(lost_, " events that came at once are not in this log");
    lost_ = 0;
  }
  return events;
}

void EventJournal::GiveBack(std::vector<Event> events) {
  waiting_.insert(waiting_.begin(), std::make_move_iterator(events.begin()),
                  std::make_move_iterator(events.end()));
}

bool EventJournal::Store(const std::vector<Event>& events) {
  try {
    const absl::Status status = store_->Write({.events = events});
    // Events that the store's rules refuse are refused for ever.
    return status.ok() || absl::IsInvalidArgument(status);
  } catch (...) {
    return false;
  }
}

void EventJournal::Run() {
  NameThread("events");
  MutexLock lock(&mutex_);
  while (true) {
    while (!is_stopped_ && waiting_.empty()) changed_.Wait(&mutex_);
    const bool is_last = is_stopped_;
    std::vector<Event> events = Take();
    if (events.empty()) return;
    is_writing_ = true;
    mutex_.Unlock();
    const bool is_stored = Store(events);
    if (is_stored) Wake();
    mutex_.Lock();
    is_writing_ = false;
    is_failing_ = !is_stored;
    if (!is_stored) GiveBack(std::move(events));
    changed_.SignalAll();
    if (is_stored) continue;
    if (is_last) return;
    const absl::Time again = absl::Now() + kRetryEvents;
    while (!is_stopped_ && !changed_.WaitWithDeadline(&mutex_, again)) {
    }
  }
}

}  // namespace isthmus::server
