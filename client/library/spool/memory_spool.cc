#include "client/library/spool/memory_spool.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <utility>

namespace isthmus::client {

SpoolIdentity MemorySpool::identity() const {
  MutexLock lock(&mutex_);
  return identity_;
}

absl::Status MemorySpool::SetIdentity(const SpoolIdentity& identity) {
  MutexLock lock(&mutex_);
  identity_ = identity;
  return absl::OkStatus();
}

absl::StatusOr<uint64_t> MemorySpool::Append(int64_t end_stamp_ns, std::string payload,
                                             double now_s) {
  MutexLock lock(&mutex_);
  bytes_ += payload.size();
  scans_.push_back({end_stamp_ns, std::move(payload), now_s});
  return first_ + scans_.size() - 1;
}

absl::Status MemorySpool::Skip(uint64_t from, uint64_t sequence) {
  MutexLock lock(&mutex_);
  if (from + 1 != first_) return absl::AbortedError("scans before those are kept");
  first_ = sequence + 1;
  return absl::OkStatus();
}

const MemorySpool::Scan* MemorySpool::Get(uint64_t sequence) const {
  if (sequence < first_ || sequence - first_ >= scans_.size()) return nullptr;
  return &scans_[sequence - first_];
}

absl::StatusOr<std::string> MemorySpool::Read(uint64_t sequence) const {
  MutexLock lock(&mutex_);
  if (const Scan* scan = Get(sequence); scan != nullptr) return scan->payload;
  return absl::NotFoundError(absl::StrCat("scan ", sequence, " is not kept"));
}

std::optional<SessionSpool::Entry> MemorySpool::Find(uint64_t sequence) const {
  MutexLock lock(&mutex_);
  const Scan* scan = Get(sequence);
  if (scan == nullptr) return std::nullopt;
  return Entry{scan->payload.size(), scan->appended_s};
}

int64_t MemorySpool::StampBefore(uint64_t sequence) const {
  MutexLock lock(&mutex_);
  if (sequence <= first_ || scans_.empty()) return stamp_before_ns_;
  return scans_[std::min<uint64_t>(sequence - first_, scans_.size()) - 1].end_stamp_ns;
}

uint64_t MemorySpool::first() const {
  MutexLock lock(&mutex_);
  return first_;
}

uint64_t MemorySpool::written() const {
  MutexLock lock(&mutex_);
  return first_ + scans_.size() - 1;
}

uint64_t MemorySpool::bytes() const {
  MutexLock lock(&mutex_);
  return bytes_;
}

void MemorySpool::Release(uint64_t durable, uint64_t acked) {
  MutexLock lock(&mutex_);
  while (!scans_.empty() && first_ <= acked && (first_ <= durable || bytes_ > most_bytes_)) {
    bytes_ -= scans_.front().payload.size();
    stamp_before_ns_ = scans_.front().end_stamp_ns;
    scans_.pop_front();
    ++first_;
  }
}

absl::Status MemorySpool::Remove() {
  MutexLock lock(&mutex_);
  first_ += scans_.size();
  scans_.clear();
  bytes_ = 0;
  return absl::OkStatus();
}

}  // namespace isthmus::client
