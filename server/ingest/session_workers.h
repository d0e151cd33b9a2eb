// The workers of the sessions that take scans, and the last status of the finished ones.
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "core/concurrency/mutex.h"
#include "core/ids.h"
#include "server/ingest/session_worker.h"

namespace isthmus::ingest {

// By the session that the robot opened. Its lock is held for a look-up only: workers are asked
// without it. Thread safe.
class SessionWorkers {
 public:
  using Worker = std::shared_ptr<SessionWorker>;

  struct Entry {
    Worker worker = {};              // Null once finished: its local map is large.
    WorkerStatus final_status = {};  // The last status, once finished.
    bool uploads = false;            // Holds uploaded submaps, so takes no scans.
  };

  void Add(const SessionId& session, Worker worker);
  void NoteUploads(const SessionId& session);
  // The session has finished.
  void Release(const SessionId& session);
  void Remove(const SessionId& session);

  // Empty for one that is not known.
  Entry Find(const SessionId& session) const;
  // The workers that are at work.
  std::vector<Worker> All() const;

 private:
  mutable Mutex mutex_;
  std::map<SessionId, Entry> entries_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace isthmus::ingest
