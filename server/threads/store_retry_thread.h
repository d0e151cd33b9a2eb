// The thread that tries again what could not be stored, while the store fails.
#pragma once

#include <thread>

#include "server/ingest/session_workers.h"
#include "server/map/map_writer.h"
#include "server/threads/store_health.h"
#include "storage/map_store.h"

namespace isthmus::server {

class StoreRetryThread {
 public:
  // `membership` is held while a session's record is written (docs/architecture.md, locks). All
  // must outlive the thread.
  StoreRetryThread(StoreHealth* health, ingest::SessionWorkers* workers, const MapWriter* map,
                   storage::MapStore* store, Mutex* membership);
  ~StoreRetryThread();  // Stops `health`, and waits.

 private:
  void Run();
  bool RetryStoring();  // True if nothing waits any more.
  bool OfferAll();      // True if nothing waits any more.

  StoreHealth* const health_;
  ingest::SessionWorkers* const workers_;
  const MapWriter* const map_;
  storage::MapStore* const store_;
  Mutex* const membership_;
  std::thread thread_;
};

}  // namespace isthmus::server
