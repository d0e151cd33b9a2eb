#include "server/threads/store_retry_thread.h"

#include "core/caught.h"
#include "core/concurrency/mutex.h"
#include "server/threads/limits.h"

namespace isthmus::server {

StoreRetryThread::StoreRetryThread(StoreHealth* health, ingest::SessionWorkers* workers,
                                   const MapWriter* map, storage::MapStore* store,
                                   Mutex* membership)
    : health_(health), workers_(workers), map_(map), store_(store), membership_(membership) {
  thread_ = std::thread([this] { Run(); });
}

StoreRetryThread::~StoreRetryThread() {
  health_->Stop();
  thread_.join();
}

void StoreRetryThread::Run() {
  while (health_->WaitForProblem()) {
    // Others' writes may succeed before what waits here was offered again.
    do {
      if (!health_->WaitFor(kRetryStoreS)) return;
    } while (!RetryStoring());
  }
}

bool StoreRetryThread::RetryStoring() {
  try {
    return OfferAll();
  } catch (...) {
    health_->NoteWrite(CaughtStatus());
    return false;
  }
}

bool StoreRetryThread::OfferAll() {
  for (const auto& worker : workers_->All()) {
    // The first that cannot be stored speaks for the others.
    if (!worker->RetryStoring().ok()) return false;
  }
  if (health_->Problem().empty()) return true;
  // Nothing waits, so whether it works again has to be found out: what is there is written anew.
  MutexLock changing(membership_);
  const MapWriter::View view = map_->view();
  if (view->sessions.empty()) return true;  // The next session that is asked for will show.
  storage::WriteBatch batch;
  batch.sessions.push_back(view->sessions.begin().value().record);
  return store_->Write(batch).ok();
}

}  // namespace isthmus::server
