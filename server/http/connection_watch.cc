#include "server/http/connection_watch.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>

#include "server/http/limits.h"

namespace isthmus::http {
namespace {

int64_t SteadyNs() { return std::chrono::steady_clock::now().time_since_epoch().count(); }

}  // namespace

void Link::Begin(Phase phase) {
  since_ns_ = SteadyNs();
  phase_ = phase;
}

bool Link::IsGone() const {
  pollfd file = {file_, POLLRDHUP, 0};
  return poll(&file, 1, 0) > 0;
}

Link* ConnectionWatch::Add(int file, const void* owner) {
  auto link = std::make_unique<Link>(file, owner);
  Link* const added = link.get();
  MutexLock lock(&mutex_);
  links_.insert(std::move(link));
  return added;
}

void ConnectionWatch::Remove(Link* link) {
  MutexLock lock(&mutex_);
  const auto found =
      std::ranges::find_if(links_, [link](const auto& one) { return one.get() == link; });
  if (found != links_.end()) links_.erase(found);
  removed_.SignalAll();
}

void ConnectionWatch::CutSlow() {
  using std::chrono::nanoseconds;
  const int64_t now_ns = SteadyNs();
  MutexLock lock(&mutex_);
  for (const auto& link : links_) {
    const Link::Phase phase = link->phase_;
    if (phase == Link::Phase::kWorking) continue;
    const nanoseconds most = phase == Link::Phase::kReceiving ? request_time_ : piece_time_;
    if (nanoseconds(now_ns - link->since_ns_) > most) shutdown(link->file_, SHUT_RDWR);
  }
}

int ConnectionWatch::CutOf(const void* owner) {
  int count = 0;
  for (const auto& link : links_) {
    if (link->owner_ != owner) continue;
    shutdown(link->file_, SHUT_RDWR);
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
