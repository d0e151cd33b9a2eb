// More sessions than are searched with each other.
#pragma once

#include <cstddef>
#include <string>

#include "tests/storage/records.h"

namespace isthmus::server {

inline SessionId NameOfMany(size_t i) { return SessionId("robot" + std::to_string(10 + i) + "-1"); }

// Finished sessions of a submap each in which hardly anything is to be seen.
inline storage::WriteBatch ManySessions(size_t count) {
  storage::WriteBatch batch;
  for (size_t i = 0; i < count; ++i) {
    const std::string name = NameOfMany(i).value();
    SessionRecord record = storage::MakeSession(name, "robot" + std::to_string(10 + i));
    record.state = SessionState::kFinished;
    record.finished_ns = record.created_ns + 1;
    batch.sessions.push_back(record);
    batch.submaps.push_back(storage::MakeSubmap(name, 0, 200));
  }
  return batch;
}

}  // namespace isthmus::server
