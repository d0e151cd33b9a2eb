#include "server/rpc/scans/ack_window.h"

#include <algorithm>
#include <utility>

namespace isthmus::rpc {

bool AckWindow::HasRoom() const {
  MutexLock lock(&mutex_);
  return !closed_ && expected_.size() + unwritten_ < limits_.scans &&
         (expected_.empty() || bytes_ < limits_.bytes);
}

void AckWindow::Expect(uint64_t sequence, std::string reason,
                       std::unique_ptr<ByteBudget::Share> share) {
  MutexLock lock(&mutex_);
  if (share != nullptr) bytes_ += share->bytes();
  expected_.push_back({sequence, std::move(reason), std::move(share)});
}

std::pair<std::string, std::unique_ptr<ByteBudget::Share>> AckWindow::Withdraw(uint64_t sequence) {
  MutexLock lock(&mutex_);
  // It may be gone: acknowledged on behalf of an earlier stream that had sent it too.
  if (expected_.empty() || expected_.back().sequence != sequence) return {};
  Expected scan = std::move(expected_.back());
  expected_.pop_back();
  if (scan.share != nullptr) bytes_ -= scan.share->bytes();
  return {std::move(scan.reason), std::move(scan.share)};
}

void AckWindow::EndScans() {
  MutexLock lock(&mutex_);
  ended_ = true;
}

void AckWindow::Add(ScanAck ack) {
  std::unique_ptr<ByteBudget::Share> share;
  {
    MutexLock lock(&mutex_);
    if (closed_) return;
    share = TakeAck(std::move(ack));
  }
  Changed();
}

std::unique_ptr<ByteBudget::Share> AckWindow::TakeAck(ScanAck ack) {
  const auto found = std::find_if(expected_.begin(), expected_.end(), [&](const Expected& scan) {
    return scan.sequence == ack.sequence;
  });
  if (found == expected_.end()) {
    AddDurable(ack.durable_sequence);
    return nullptr;
  }
  if (ack.outcome == ScanOutcome::kRejected && !found->reason.empty()) {
    ack.reason = std::move(found->reason);
  }
  std::unique_ptr<ByteBudget::Share> share = std::move(found->share);
  if (share != nullptr) bytes_ -= share->bytes();
  expected_.erase(found);
  acks_.push_back(std::move(ack));
  ++unwritten_;
  return share;
}

void AckWindow::AddDurable(uint64_t durable_sequence) {
  // Only the newest counts, so two in a row become one: acks_ stays within twice the limit.
  if (acks_.empty() || acks_.back().sequence != 0) acks_.emplace_back();
  acks_.back().durable_sequence = std::max(acks_.back().durable_sequence, durable_sequence);
}

std::optional<ScanAck> AckWindow::Next() {
  MutexLock lock(&mutex_);
  if (closed_ || acks_.empty()) return std::nullopt;
  std::optional<ScanAck> ack(std::move(acks_.front()));
  acks_.pop_front();
  if (ack->sequence != 0) --unwritten_;
  return ack;
}

bool AckWindow::drained() const {
  MutexLock lock(&mutex_);
  return closed_ || (acks_.empty() && ended_ && expected_.empty());
}

void AckWindow::Close() {
  std::deque<Expected> expected;  // Gives back its shares outside of the lock.
  {
    MutexLock lock(&mutex_);
    closed_ = true;
    acks_.clear();
    expected.swap(expected_);
    bytes_ = 0;
  }
  Changed();
}

bool AckWindow::closed() const {
  MutexLock lock(&mutex_);
  return closed_;
}

void AckWindow::Changed() const {
  if (on_change_) on_change_();
}

}  // namespace isthmus::rpc
