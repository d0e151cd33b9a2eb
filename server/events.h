// The event log of a map: what happened, and who did it.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>

#include "core/records/event.h"

namespace isthmus::server {

// Thread safe.
class Events {
 public:
  virtual ~Events() = default;

  // The stored part of the log, which may lack the events of a moment ago.
  virtual absl::StatusOr<EventPage> List(const EventQuery& query) const = 0;
  // An event that is none of the map's; it is in the log soon. Never waits. Without a time it is
  // now; texts that are too long are cut; of no kind it is dropped.
  virtual void Note(Event event) = 0;

  // `wake` is called, from any thread, after events were stored; it must not block. Once Forget
  // returns, or while it does, one last call may be under way.
  virtual uint64_t OnStored(std::function<void()> wake) = 0;
  virtual void Forget(uint64_t handle) = 0;
};

}  // namespace isthmus::server
