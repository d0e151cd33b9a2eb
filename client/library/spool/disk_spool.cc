#include "client/library/spool/disk_spool.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <utility>

#include "core/io/folder.h"

namespace isthmus::client {
namespace {

constexpr double kLongAgo = -std::numeric_limits<double>::infinity();

}  // namespace

absl::StatusOr<std::unique_ptr<DiskSpool>> DiskSpool::Create(const std::string& folder,
                                                             const SpoolIdentity& identity,
                                                             const Options& options) {
  std::error_code error;
  if (!std::filesystem::create_directories(folder, error)) {
    return absl::FailedPreconditionError(absl::StrCat(
        "cannot make ", folder, ": ", error ? error.message() : "it is there already"));
  }
  std::unique_ptr<DiskSpool> spool(new DiskSpool(folder, identity, options));
  absl::Status status = WriteIdentity(folder, identity);
  if (status.ok()) {
    MutexLock writing(&spool->write_mutex_);
    status = spool->StartPart();
  }
  if (status.ok()) status = io::SyncNameOf(folder);
  if (status.ok()) return spool;
  std::filesystem::remove_all(folder, error);
  return status;
}

absl::StatusOr<std::unique_ptr<DiskSpool>> DiskSpool::Open(const std::string& folder,
                                                           const Options& options) {
  auto identity = ReadIdentity(folder);
  if (!identity.ok()) return identity.status();
  std::unique_ptr<DiskSpool> spool(new DiskSpool(folder, *identity, options));
  if (absl::Status status = spool->Load(); !status.ok()) return status;
  return spool;
}

absl::Status DiskSpool::Load() {
  const absl::StatusOr<std::vector<uint64_t>> firsts = io::ListNumbers(folder_, kScansSuffix);
  if (!firsts.ok()) return firsts.status();
  for (const uint64_t first : *firsts) {
    if (absl::Status status = LoadPart(first, first == firsts->back()); !status.ok()) return status;
  }
  if (parts_.empty()) return StartPart();
  const Part& last = parts_.back();
  written_ = last.segment->header().first_sequence - 1;
  if (!last.entries.empty()) written_ = last.entries.back().scan.sequence;
  safe_ = written_;
  for (const Part& part : parts_) bytes_ += part.segment->bytes();
  return absl::OkStatus();
}

absl::Status DiskSpool::LoadPart(uint64_t first_sequence, bool newest) {
  const std::string path = PathOf(first_sequence);
  auto segment = SpoolSegment::Open(path, {identity_.name(), first_sequence, 0}, *options_.disk);
  if (!segment.ok()) return segment.status();
  const SegmentHeader& header = (*segment)->header();
  if (header.owner != identity_.name() || header.first_sequence != first_sequence) {
    return UnknownOwner(folder_, path + " is a file of another spool, or has the name of another");
  }
  // A torn record can only be at the end of the newest file; elsewhere a scan is looked at when it
  // is sent.
  auto contents = (*segment)->Find(newest ? io::Look::kBodies : io::Look::kHeaders);
  if (!contents.ok()) return contents.status();
  // The program died before the file had taken a scan; the next one gets its name.
  if ((*segment)->headless() && contents->records.empty() && newest) return absl::OkStatus();
  for (const io::DamagedBytes& damaged : contents->damaged) {
    notes_.push_back(absl::StrCat(path, ": ", damaged.size, " bytes at ", damaged.offset,
                                  " are damaged; the scans in them are lost"));
  }
  if (const uint64_t behind = (*segment)->bytes() - contents->end; newest && behind > 0) {
    notes_.push_back(absl::StrCat(path, ": cut off ", behind,
                                  " bytes of a scan that was not written to the end"));
    absl::Status status = (*segment)->Truncate(contents->end);
    if (!status.ok()) return status;
  }
  if (newest) {
    if (absl::Status status = (*segment)->Sync(); !status.ok()) return status;
    spoilt_ = (*segment)->headless();
  }
  Part part{*std::move(segment), {}};
  for (const io::Record& scan : contents->records) part.entries.push_back({scan, kLongAgo});
  parts_.push_back(std::move(part));
  return absl::OkStatus();
}

SpoolIdentity DiskSpool::identity() const {
  MutexLock lock(&mutex_);
  return identity_;
}

absl::Status DiskSpool::SetIdentity(const SpoolIdentity& identity) {
  MutexLock lock(&mutex_);
  if (absl::Status status = WriteIdentity(folder_, identity); !status.ok()) return status;
  identity_ = identity;
  return absl::OkStatus();
}

std::string DiskSpool::PathOf(uint64_t first_sequence) const {
  return absl::StrFormat("%s/%020d%s", folder_, first_sequence, kScansSuffix);
}

absl::Status DiskSpool::StartPart() {
  SegmentHeader header;
  {
    MutexLock lock(&mutex_);
    header = {identity_.name(), written_ + 1, 0};
  }
  header.stamp_before_ns = StampBefore(header.first_sequence);
  auto segment = SpoolSegment::Create(PathOf(header.first_sequence), header, *options_.disk);
  if (!segment.ok()) return segment.status();
  if (absl::Status status = io::SyncFolder(folder_); !status.ok()) return status;
  spoilt_ = false;
  MutexLock lock(&mutex_);
  // A file that failed before it took a scan leaves its name to the next.
  if (!parts_.empty() && parts_.back().entries.empty()) {
    bytes_ -= parts_.back().segment->bytes();
    parts_.pop_back();
  }
  bytes_ += (*segment)->bytes();
  parts_.push_back({*std::move(segment), {}});
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<SpoolSegment>> DiskSpool::PartToWrite(double now_s) {
  std::shared_ptr<SpoolSegment> segment;
  {
    MutexLock lock(&mutex_);
    segment = parts_.back().segment;
  }
  if (!spoilt_ && segment->bytes() < options_.segment_bytes) return segment;
  if (absl::Status status = SyncWritten(now_s); !status.ok()) return status;
  if (absl::Status status = StartPart(); !status.ok()) return status;
  MutexLock lock(&mutex_);
  return parts_.back().segment;
}

absl::StatusOr<uint64_t> DiskSpool::Append(int64_t end_stamp_ns, std::string payload,
                                           double now_s) {
  MutexLock writing(&write_mutex_);
  const absl::StatusOr<uint64_t> sequence = Write(end_stamp_ns, payload, now_s);
  const bool is_full = absl::IsResourceExhausted(sequence.status());
  return is_full && MakeWay(now_s) ? Write(end_stamp_ns, payload, now_s) : sequence;
}

absl::StatusOr<uint64_t> DiskSpool::Write(int64_t end_stamp_ns, const std::string& payload,
                                          double now_s) {
  auto segment = PartToWrite(now_s);
  if (!segment.ok()) return segment.status();
  const uint64_t before = (*segment)->bytes();
  const uint64_t sequence = written() + 1;
  const auto scan = (*segment)->Append(sequence, end_stamp_ns, payload);
  if (!scan.ok()) return scan.status();
  const bool due = now_s >= synced_s_ + options_.sync_interval_s;
  absl::Status synced = due ? (*segment)->Sync() : absl::OkStatus();
  if (!synced.ok()) spoilt_ = true;
  if (!synced.ok() && options_.sync_interval_s <= 0) {
    (void)(*segment)->Truncate(before);
    return synced;
  }
  MutexLock lock(&mutex_);
  parts_.back().entries.push_back({*scan, now_s});
  bytes_ += (*segment)->bytes() - before;
  written_ = sequence;
  if (due && synced.ok()) {
    safe_ = sequence;
    synced_s_ = now_s;
  } else if (due) {
    notes_.push_back(
        absl::StrCat("not yet safe from a power cut: ", std::string(synced.message())));
  }
  return sequence;
}

bool DiskSpool::MakeWay(double now_s) {
  {
    MutexLock lock(&mutex_);
    if (parts_.back().entries.empty()) return false;
  }
  if (!SyncWritten(now_s).ok()) return false;
  // A file of its own for the next scan lets this one go.
  if (StartPart().ok()) {
    MutexLock lock(&mutex_);
    return ReleaseFront();
  }
  {
    MutexLock lock(&mutex_);
    if (durable_ < written_) return false;
    // There is no room for another file, and nothing in this one is needed. Should the program die
    // before the other is there, the server knows the next scan's number.
    SpoolSegment& last = *parts_.back().segment;
    unlink(last.path().c_str());
    bytes_ -= last.bytes();
    if (!last.Truncate(0).ok()) bytes_ += last.bytes();
    spoilt_ = true;
  }
  return StartPart().ok();
}

absl::Status DiskSpool::Sync(double now_s) {
  MutexLock writing(&write_mutex_);
  return SyncWritten(now_s);
}

absl::Status DiskSpool::Skip(uint64_t from, uint64_t sequence) {
  MutexLock writing(&write_mutex_);
  if (from != written()) return absl::AbortedError("a scan was written meanwhile");
  if (absl::Status status = SyncWritten(0); !status.ok()) return status;
  {
    MutexLock lock(&mutex_);
    written_ = safe_ = sequence;
  }
  return StartPart();  // Its header keeps the number.
}

absl::Status DiskSpool::SyncWritten(double now_s) {
  std::shared_ptr<SpoolSegment> segment;
  {
    MutexLock lock(&mutex_);
    if (safe_ == written_) return absl::OkStatus();
    segment = parts_.back().segment;
  }
  if (absl::Status status = segment->Sync(); !status.ok()) return status;
  synced_s_ = now_s;
  MutexLock lock(&mutex_);
  safe_ = written_;
  return absl::OkStatus();
}

absl::StatusOr<std::string> DiskSpool::Read(uint64_t sequence) const {
  std::shared_ptr<SpoolSegment> segment;
  io::Record scan;
  {
    MutexLock lock(&mutex_);
    for (const Part& part : parts_) {
      const auto at = std::lower_bound(part.entries.begin(), part.entries.end(), sequence, IsBelow);
      if (at == part.entries.end() || at->scan.sequence != sequence) continue;
      segment = part.segment;
      scan = at->scan;
    }
  }
  if (segment != nullptr) return segment->Read(scan);
  return absl::NotFoundError(absl::StrCat("the spool ", folder_, " does not hold scan ", sequence));
}

std::optional<DiskSpool::Entry> DiskSpool::Find(uint64_t sequence) const {
  MutexLock lock(&mutex_);
  for (const Part& part : parts_) {
    const auto at = std::lower_bound(part.entries.begin(), part.entries.end(), sequence, IsBelow);
    if (at != part.entries.end() && at->scan.sequence == sequence) {
      return Entry{at->scan.size, at->appended_s};
    }
  }
  return std::nullopt;
}

int64_t DiskSpool::StampBefore(uint64_t sequence) const {
  MutexLock lock(&mutex_);
  int64_t stamp = 0;
  for (const Part& part : parts_) {
    if (part.segment->header().first_sequence > sequence) break;
    if (part.segment->header().stamp_before_ns != 0) stamp = part.segment->header().stamp_before_ns;
    const auto at = std::lower_bound(part.entries.begin(), part.entries.end(), sequence, IsBelow);
    if (at != part.entries.begin()) stamp = std::prev(at)->scan.stamp_ns;
  }
  return stamp;
}

uint64_t DiskSpool::first() const {
  MutexLock lock(&mutex_);
  return parts_.front().segment->header().first_sequence;
}

uint64_t DiskSpool::safe() const {
  MutexLock lock(&mutex_);
  return safe_;
}

uint64_t DiskSpool::written() const {
  MutexLock lock(&mutex_);
  return written_;
}

uint64_t DiskSpool::bytes() const {
  MutexLock lock(&mutex_);
  return bytes_;
}

void DiskSpool::Release(uint64_t durable, uint64_t) {
  MutexLock lock(&mutex_);
  durable_ = std::max(durable_, durable);
  (void)ReleaseFront();
}

bool DiskSpool::ReleaseFront() {
  bool released = false;
  while (parts_.size() > 1 && parts_[1].segment->header().first_sequence <= durable_ + 1) {
    RemoveFront();
    released = true;
  }
  return released;
}

bool DiskSpool::DropOldest() {
  MutexLock lock(&mutex_);
  if (parts_.size() < 2) return false;
  RemoveFront();
  return true;
}

void DiskSpool::RemoveFront() {
  bytes_ -= parts_.front().segment->bytes();
  unlink(parts_.front().segment->path().c_str());
  parts_.pop_front();
}

absl::Status DiskSpool::Remove() {
  MutexLock writing(&write_mutex_);
  MutexLock lock(&mutex_);
  if (absl::Status status = RetireIdentity(folder_); !status.ok()) return status;
  std::error_code error;
  std::filesystem::remove_all(folder_, error);
  if (!error) return absl::OkStatus();
  return absl::UnavailableError(absl::StrCat("cannot remove ", folder_, ": ", error.message()));
}

std::vector<std::string> DiskSpool::TakeNotes() {
  MutexLock lock(&mutex_);
  return std::exchange(notes_, {});
}

}  // namespace isthmus::client
