#include "server/map/map_writer.h"

#include <optional>
#include <utility>

#include "core/concurrency/mutex.h"
#include "server/map/edit_events.h"
#include "server/map/limits.h"

namespace isthmus::server {
namespace {

template <typename T>
void Append(const std::vector<T>& more, std::vector<T>* all) {
  all->insert(all->end(), more.begin(), more.end());
}

void Append(const Changes& more, Changes* all) {
  for (const std::string& cause : more.causes) {
    if (all->causes.size() > kMaxCauses) break;
    all->causes.push_back(all->causes.size() < kMaxCauses ? cause : "and more");
  }
  Append(more.matches, &all->matches);
  Append(more.loops, &all->loops);
}

}  // namespace

MapWriter::View MapWriter::view() const {
  MutexLock lock(&mutex_);
  return view_;
}

absl::Status MapWriter::CommitEdit(const MapEdit& edit) {
  if (absl::Status status = store_->Write(edit.batch); !status.ok()) return status;
  (void)ShowEdit(edit);
  return absl::OkStatus();
}

bool MapWriter::ShowEdit(const MapEdit& edit) {
  const View now = view();
  std::vector<Event> events;
  bool is_shown = false;
  if (!ChangesMatches(edit, *now)) {
    is_shown = ShowPrepared(edit, Prepare(edit, *now), &events);
  } else {
    // Others that do not change matches show theirs while cycles are checked.
    MutexLock matching(&matching_);
    is_shown = ShowPrepared(edit, Prepare(edit, *view()), &events);
  }
  for (Event& event : events) events_->Note(std::move(event));
  return is_shown;
}

bool MapWriter::ShowPrepared(const MapEdit& edit, const PreparedEdit& prepared,
                             std::vector<Event>* events) {
  View base, shown;  // May be the last that hold a large map: let go of without a lock.
  {
    MutexLock editing(&editing_);
    base = view();
    if (IsVoid(edit, *base)) return false;
    shown = Apply(*base, edit, prepared);
    MutexLock lock(&mutex_);
    Append(edit.changes, &changes_);
    view_ = shown;
  }
  if (events_ != nullptr && prepared.effective != nullptr) {
    *events = Stamped(MatchEvents(*base->effective, *shown->effective, *shown));
  }
  changed_.Notify();
  activity_->changed().Notify();
  return true;
}

std::vector<Event> MapWriter::Stamped(std::vector<Event> events) const {
  for (Event& event : events) event.time_ns = clock_->NowNs();
  return events;
}

void MapWriter::GiveBack(Changes changes) {
  MutexLock lock(&mutex_);
  std::swap(changes, changes_);
  Append(changes, &changes_);
}

MapWriter::ToPlace MapWriter::TakeChanges() {
  MutexLock lock(&mutex_);
  return {view_, std::exchange(changes_, {})};
}

void MapWriter::ShowPlaced(PlacedMap placed) {
  MapEdit edit;
  edit.placed = std::move(placed);
  (void)ShowEdit(edit);
}

void MapWriter::ShowComposed(std::shared_ptr<const ComposedMap> map) {
  MapEdit edit;
  edit.composed = std::move(map);
  (void)ShowEdit(edit);
}

void MapWriter::EndPlacing() {
  {
    MutexLock lock(&mutex_);
    placing_ = false;
  }
  changed_.Notify();
  activity_->changed().Notify();
}

void MapWriter::WaitUntilPlaced() const {
  const uint64_t wanted = view()->graph_version;
  while (true) {
    const uint64_t seen = changed_.count();
    {
      MutexLock lock(&mutex_);
      if (!placing_ || view_->placed_version >= wanted) return;
    }
    changed_.WaitPast(seen);
  }
}

}  // namespace isthmus::server
