// The event log as stores in memory keep it, and the rules for a page of one in every store.
#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "core/records/event.h"

namespace isthmus::storage {

// The page of these events, in order of number, that answer the query.
EventPage MakeEventPage(const EventQuery& query, std::vector<Event> events, uint64_t first_kept,
                        uint64_t newest);

// MapStore's promises about events, kept in memory. Not thread safe.
class EventLog {
 public:
  void Add(const std::vector<Event>& events);
  EventPage List(const EventQuery& query) const;

 private:
  std::deque<Event> events_;  // In order of number, without gaps.
  uint64_t newest_ = 0;
};

}  // namespace isthmus::storage
