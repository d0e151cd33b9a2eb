#include "storage/event_log.h"

#include <algorithm>
#include <utility>

#include "storage/map_store.h"

namespace isthmus::storage {

EventPage MakeEventPage(const EventQuery& query, std::vector<Event> events, uint64_t first_kept,
                        uint64_t newest) {
  EventPage page;
  page.after = query.after.value_or(0);
  page.first_kept = first_kept;
  page.newest = newest;
  const bool is_cut = query.after && events.size() >= query.limit;
  const uint64_t last = events.empty() ? query.after.value_or(0) : events.back().number;
  page.up_to = is_cut ? last : newest;
  page.events = std::move(events);
  return page;
}

void EventLog::Add(const std::vector<Event>& events) {
  for (const Event& event : events) {
    events_.push_back(event);
    events_.back().number = ++newest_;
  }
  while (events_.size() > kEventsKept) events_.pop_front();
}

EventPage EventLog::List(const EventQuery& query) const {
  std::vector<Event> found;
  const auto take = [&](const Event& event) {
    if (found.size() < query.limit && IsWanted(query, event)) found.push_back(event);
  };
  if (query.after) {
    for (const Event& event : events_) {
      if (event.number > *query.after) take(event);
    }
  } else {
    std::for_each(events_.rbegin(), events_.rend(), take);
    std::reverse(found.begin(), found.end());
  }
  const uint64_t first_kept = newest_ + 1 - events_.size();
  return MakeEventPage(query, std::move(found), first_kept, newest_);
}

}  // namespace isthmus::storage
