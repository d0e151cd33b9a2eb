// What is done while the store fails: trying again until it works.
#include <utility>

#include "server/pipeline/pipeline_impl.h"

namespace isthmus::server {
namespace {

constexpr double kRetryS = 1;

}  // namespace

void PipelineImpl::RunStoreRetries() {
  while (health_.WaitForProblem()) {
    // Others' writes may succeed before what waits here was offered again.
    do {
      if (!health_.Pause(kRetryS)) return;
    } while (!RetryStoring());
  }
}

bool PipelineImpl::RetryStoring() {
  std::vector<std::shared_ptr<ingest::SessionWorker>> workers;
  {
    std::lock_guard lock(state_.mutex);
    for (const auto& [id, entry] : state_.sessions) {
      if (entry.worker != nullptr) workers.push_back(entry.worker);
    }
  }
  for (const auto& worker : workers) {
    // The first that cannot be stored speaks for the others.
    if (!worker->RetryStoring().ok()) return false;
  }
  if (health_.Problem().empty()) return true;
  // Nothing waits, so whether it works again has to be found out: what is there is written anew.
  std::lock_guard changing(membership_mutex_);
  storage::WriteBatch batch;
  {
    std::lock_guard lock(state_.mutex);
    if (state_.sessions.empty()) return true;  // The next session that is asked for will show.
    batch.sessions.push_back(state_.sessions.begin()->second.record);
  }
  return store_->Write(batch).ok();
}

}  // namespace isthmus::server
