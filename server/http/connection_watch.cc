#include "server/http/connection_watch.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>

#include "server/http/limits.h"

namespace isthmus::http {
namespace {

int64_t SteadyNs() { return std::chrono::steady_clock::now().time_since_epoch().count(); }

}  // namespace

void Connection::Begin(Phase phase) {
  since_ns_ = SteadyNs();
  phase_ = phase;
}

bool Connection::IsGone() const {
  pollfd file = {file_, POLLRDHUP, 0};
  return poll(&file, 1, 0) > 0;
}

Connection* ConnectionWatch::Add(int file, const void* owner) {
  auto watched = std::make_unique<Connection>(file, owner);
  Connection* const added = watched.get();
  MutexLock lock(&mutex_);
  connections_.insert(std::move(watched));
  return added;
}

void ConnectionWatch::Remove(Connection* watched) {
  MutexLock lock(&mutex_);
  const auto found = std::ranges::find_if(
      connections_, [watched](const auto& one) { return one.get() == watched; });
  if (found != connections_.end()) connections_.erase(found);
  removed_.SignalAll();
}

void ConnectionWatch::CutSlow() {
  using std::chrono::nanoseconds;
  const int64_t now_ns = SteadyNs();
  MutexLock lock(&mutex_);
  for (const auto& watched : connections_) {
    const Connection::Phase phase = watched->phase_;
    if (phase == Connection::Phase::kWorking) continue;
    const nanoseconds most = phase == Connection::Phase::kReceiving ? request_time_ : piece_time_;
    if (nanoseconds(now_ns - watched->since_ns_) > most) shutdown(watched->file_, SHUT_RDWR);
  }
}

int ConnectionWatch::CutOf(const void* owner) {
  int count = 0;
  for (const auto& watched : connections_) {
    if (watched->owner_ != owner) continue;
    shutdown(watched->file_, SHUT_RDWR);
    ++count;
  }
  return count;
}

void ConnectionWatch::CutAll(const void* owner, std::chrono::milliseconds patience) {
  const int64_t until_ns = SteadyNs() + std::chrono::nanoseconds(patience).count();
  MutexLock lock(&mutex_);
  // Again and again: one may have been under way.
  while (CutOf(owner) > 0 && SteadyNs() < until_ns) removed_.WaitFor(&mutex_, kCutInterval);
}

}  // namespace isthmus::http
