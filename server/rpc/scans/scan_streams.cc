#include "server/rpc/scans/scan_streams.h"

#include <utility>

namespace isthmus::rpc {

ScanStreams::Registration::~Registration() { streams_.Unregister(this); }

absl::StatusOr<std::unique_ptr<ScanStreams::Registration>> ScanStreams::Register(
    const SessionId& session, std::function<void()> on_change) {
  std::unique_ptr<Registration> registration(
      new Registration(*this, session, window_, std::move(on_change)));
  MutexLock lock(&mutex_);
  const absl::Status status = sessions_.SetAckSink(
      session, [window = registration->window_](const ScanAck& ack) { window->Add(ack); });
  if (!status.ok()) return status;
  Registration*& current = current_[session];
  if (current != nullptr) current->window_->Close();
  current = registration.get();
  return registration;
}

void ScanStreams::Drop(const SessionId& session) {
  MutexLock lock(&mutex_);
  const auto found = current_.find(session);
  if (found != current_.end()) found->second->window_->Close();
}

void ScanStreams::Unregister(Registration* registration) {
  MutexLock lock(&mutex_);
  const auto found = current_.find(registration->session_);
  if (found == current_.end() || found->second != registration)
    return;  // A newer stream took over.
  current_.erase(found);
  // The session may be gone by now; then there is no sink to take away either.
  (void)sessions_.SetAckSink(registration->session_, nullptr);
}

}  // namespace isthmus::rpc
