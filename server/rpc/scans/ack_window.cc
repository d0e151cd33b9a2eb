#include "server/rpc/scans/ack_window.h"

#include <algorithm>
#include <utility>

namespace isthmus::rpc {

bool AckWindow::WaitForRoom() {
  MutexLock lock(&mutex_);
  while (!closed_ && !stopped_ && expected_.size() + unwritten_ >= limit_) changed_.Wait(&mutex_);
  return !closed_ && !stopped_;
}

void AckWindow::Expect(uint64_t sequence, std::string reason) {
  MutexLock lock(&mutex_);
  expected_.push_back({sequence, std::move(reason)});
}

void AckWindow::Withdraw(uint64_t sequence) {
  MutexLock lock(&mutex_);
  // It may be gone: acknowledged on behalf of an earlier stream that had sent it too.
  if (!expected_.empty() && expected_.back().sequence == sequence) expected_.pop_back();
  changed_.SignalAll();
}

void AckWindow::EndScans() {
  MutexLock lock(&mutex_);
  ended_ = true;
  changed_.SignalAll();
}

bool AckWindow::scans_ended() const {
  MutexLock lock(&mutex_);
  return ended_;
}

void AckWindow::Add(ScanAck ack) {
  MutexLock lock(&mutex_);
  if (closed_) return;
  const auto found = std::find_if(expected_.begin(), expected_.end(), [&](const Expected& scan) {
    return scan.sequence == ack.sequence;
  });
  if (found == expected_.end()) {
    AddDurable(ack.durable_sequence);
  } else {
    if (ack.outcome == ScanOutcome::kRejected && !found->reason.empty()) {
      ack.reason = std::move(found->reason);
    }
    expected_.erase(found);
    acks_.push_back(std::move(ack));
    ++unwritten_;
  }
  changed_.SignalAll();
}

void AckWindow::AddDurable(uint64_t durable_sequence) {
  // Only the newest counts, so two in a row become one: acks_ stays within twice the limit.
  if (acks_.empty() || acks_.back().sequence != 0) acks_.emplace_back();
  acks_.back().durable_sequence = std::max(acks_.back().durable_sequence, durable_sequence);
}

std::optional<ScanAck> AckWindow::Next() {
  MutexLock lock(&mutex_);
  while (!closed_ && acks_.empty() && !((ended_ || stopped_) && expected_.empty())) {
    changed_.Wait(&mutex_);
  }
  if (closed_ || acks_.empty()) return std::nullopt;
  std::optional<ScanAck> ack(std::move(acks_.front()));
  acks_.pop_front();
  if (ack->sequence != 0) --unwritten_;
  changed_.SignalAll();
  return ack;
}

void AckWindow::Stop() {
  MutexLock lock(&mutex_);
  stopped_ = true;
  changed_.SignalAll();
}

void AckWindow::Close() {
  MutexLock lock(&mutex_);
  closed_ = true;
  acks_.clear();
  changed_.SignalAll();
}

}  // namespace isthmus::rpc
