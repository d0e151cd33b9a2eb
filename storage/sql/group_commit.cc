#include "storage/sql/group_commit.h"

#include "core/caught.h"

namespace isthmus::storage {
namespace {

// Bounds the wait of the first of a group for the last.
constexpr size_t kMaxGroup = 64;

// Bounds the times that one is taken back for others: a conflict each time is no chance.
constexpr int kMaxAttempts = 3;

}  // namespace

absl::Status GroupCommit::Run(const Work& work) {
  Request request(work);
  Group group;  // Begins with the oldest that waits, which need not be this thread's.
  group.reserve(kMaxGroup);
  {
    MutexLock lock(&mutex_);
    waiting_.push_back(&request);
    while (!request.is_done && is_led_) changed_.Wait(&mutex_);
    if (request.is_done) return request.status;
    is_led_ = true;
  }
  while (!request.is_done) {
    group.clear();
    bool is_committed = false;
    try {
      is_committed = CommitTogether(group);
    } catch (...) {
      // Taken back with all the others; each is told its own by itself.
    }
    for (Request* settled : group) {
      const bool is_lost = !is_committed || absl::IsAborted(settled->status);
      if (is_lost) CommitAlone(*settled);
    }
    MutexLock lock(&mutex_);
    for (Request* settled : group) settled->is_done = true;
    changed_.SignalAll();
    if (request.is_done) is_led_ = false;
  }
  return request.status;
}

GroupCommit::Request* GroupCommit::Next(size_t size) {
  MutexLock lock(&mutex_);
  if (waiting_.empty() || size >= kMaxGroup) return nullptr;
  Request* request = waiting_.front();
  waiting_.pop_front();
  return request;
}

bool GroupCommit::CommitTogether(Group& group) {
  Transaction transaction(*writer_);
  while (Request* request = Next(group.size())) {
    group.push_back(request);
    if (!transaction.status().ok()) {
      request->status = transaction.status();
      continue;
    }
    Savepoint savepoint(*writer_);
    request->status = savepoint.status();
    if (request->status.ok()) request->status = request->work(*writer_);
    if (request->status.ok()) request->status = savepoint.Release();
    // A full disk, for one, takes back all there was before it.
    if (!writer_->InTransaction()) return false;
  }
  if (!transaction.status().ok()) return true;  // All know that they could not even begin.
  return transaction.Commit().ok();
}

absl::Status GroupCommit::TryAlone(const Work& work) {
  try {
    Transaction transaction(*writer_);
    absl::Status status = transaction.status();
    if (status.ok()) status = work(*writer_);
    if (status.ok()) status = transaction.Commit();
    return status;
  } catch (...) {
    return CaughtStatus();
  }
}

void GroupCommit::CommitAlone(Request& request) {
  for (int attempt = 0; attempt < kMaxAttempts; ++attempt) {
    request.status = TryAlone(request.work);
    if (!absl::IsAborted(request.status)) return;
  }
  request.status = absl::UnavailableError(request.status.message());
}

}  // namespace isthmus::storage
