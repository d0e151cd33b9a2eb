#include "server/pipeline/compositor.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/stopwatch.h"

namespace isthmus::server {

Compositor::Compositor(MapState* state, SubmapReader reader,
                       const composition::ComposerOptions& options, double interval_s)
    : state_(state), reader_(std::move(reader)), interval_s_(interval_s), composer_(options) {
  state_->map = composer_.Compose(0, {}, reader_);
  thread_ = std::thread([this] { Run(); });
}

Compositor::~Compositor() {
  Stop();
  thread_.join();
}

void Compositor::Stop() {
  std::lock_guard lock(state_->mutex);
  stop_ = true;
  state_->changed.notify_all();
}

void Compositor::Run() {
  using SteadyClock = std::chrono::steady_clock;
  SteadyClock::time_point next_allowed = SteadyClock::now();
  std::unique_lock lock(state_->mutex);
  while (true) {
    if (state_->IsComposed()) {
      if (stop_) return;
      state_->changed.wait(lock);
      continue;
    }
    if (!stop_ && SteadyClock::now() < next_allowed) {
      state_->changed.wait_until(lock, next_allowed);
      continue;
    }
    const int64_t revision = state_->revision.revision;
    const std::vector<PlacedSubmap> placed = state_->PlacedSubmaps();
    lock.unlock();
    Stopwatch watch;
    std::shared_ptr<const ComposedMap> map = composer_.Compose(revision, placed, reader_);
    const double ms = watch.Ms();
    lock.lock();
    state_->map = std::move(map);
    state_->composed_revision = revision;
    state_->composition_ms = ms;
    state_->composition_max_ms = std::max(state_->composition_max_ms, ms);
    ++state_->compositions;
    state_->changed.notify_all();
    next_allowed = SteadyClock::now() + std::chrono::microseconds(int64_t(interval_s_ * 1e6));
  }
}

}  // namespace isthmus::server
