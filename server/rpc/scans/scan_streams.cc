#include "server/rpc/scans/scan_streams.h"

#include <utility>

namespace isthmus::rpc {

ScanStreams::Seat::~Seat() { streams_.Leave(this); }

void ScanStreams::Seat::Hang() {
  window_->Close();
  cancel_();
}

absl::StatusOr<std::unique_ptr<ScanStreams::Seat>> ScanStreams::Join(const SessionId& session,
                                                                     std::function<void()> cancel) {
  std::unique_ptr<Seat> seat(new Seat(*this, session, window_, std::move(cancel)));
  MutexLock lock(&mutex_);
  if (stopped_) return absl::UnavailableError("the server is shutting down; try again");
  const absl::Status status = pipeline_.SetAckSink(
      session, [window = seat->window_](const ScanAck& ack) { window->Add(ack); });
  if (!status.ok()) return status;
  Seat*& current = current_[session];
  if (current != nullptr) current->Hang();
  current = seat.get();
  return seat;
}

void ScanStreams::Drop(const SessionId& session) {
  MutexLock lock(&mutex_);
  const auto found = current_.find(session);
  if (found != current_.end()) found->second->Hang();
}

void ScanStreams::StopAll() {
  MutexLock lock(&mutex_);
  stopped_ = true;
  for (const auto& [session, seat] : current_) seat->window_->Stop();
}

void ScanStreams::Leave(Seat* seat) {
  MutexLock lock(&mutex_);
  const auto found = current_.find(seat->session_);
  if (found == current_.end() || found->second != seat) return;  // A newer stream took over.
  current_.erase(found);
  // The session may be gone by now; then there is no sink to take away either.
  (void)pipeline_.SetAckSink(seat->session_, nullptr);
}

}  // namespace isthmus::rpc
