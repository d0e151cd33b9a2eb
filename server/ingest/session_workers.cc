#include "server/ingest/session_workers.h"

#include <utility>

#include "core/concurrency/mutex.h"

namespace isthmus::ingest {

void SessionWorkers::Add(const SessionId& session, Worker worker) {
  MutexLock lock(&mutex_);
  entries_[session].worker = std::move(worker);
}

void SessionWorkers::NoteUploads(const SessionId& session) {
  MutexLock lock(&mutex_);
  const auto found = entries_.find(session);
  if (found != entries_.end()) found->second.uploads = true;
}

void SessionWorkers::Release(const SessionId& session) {
  Worker worker = Find(session).worker;
  if (worker == nullptr) return;
  WorkerStatus status = worker->Status();
  MutexLock lock(&mutex_);
  const auto found = entries_.find(session);
  if (found == entries_.end()) return;
  found->second.final_status = std::move(status);
  found->second.worker = nullptr;  // `worker` still holds it: it goes without the lock.
}

void SessionWorkers::Remove(const SessionId& session) {
  Entry gone;
  MutexLock lock(&mutex_);
  const auto found = entries_.find(session);
  if (found == entries_.end()) return;
  gone = std::move(found->second);
  entries_.erase(found);
}

SessionWorkers::Entry SessionWorkers::Find(const SessionId& session) const {
  MutexLock lock(&mutex_);
  const auto found = entries_.find(session);
  return found == entries_.end() ? Entry() : found->second;
}

std::vector<SessionWorkers::Worker> SessionWorkers::All() const {
  MutexLock lock(&mutex_);
  std::vector<Worker> workers;
  for (const auto& [session, entry] : entries_) {
    if (entry.worker != nullptr) workers.push_back(entry.worker);
  }
  return workers;
}

}  // namespace isthmus::ingest
