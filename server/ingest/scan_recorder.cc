#include "server/ingest/scan_recorder.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <utility>

#include "core/codec/quantized.h"
#include "core/concurrency/mutex.h"

namespace isthmus::ingest {

namespace {

// A payload that is quantised already, or that no decoder takes, is left as it is.
PointPayload RoundScan(const PointPayload& payload, double resolution_m) {
  if (payload.encoding != PayloadEncoding::kRaw) return payload;
  absl::StatusOr<PointPayload> rounded = codec::Quantize(payload, resolution_m);
  return rounded.ok() ? *std::move(rounded) : payload;
}

}  // namespace

absl::StatusOr<std::unique_ptr<ScanRecorder>> ScanRecorder::Open(
    const server::ArchiveOptions& options, std::function<void(const std::string&)> on_problem,
    uint64_t max_points) {
  std::unique_ptr<storage::ScanArchive> archive;
  if (!options.directory.empty()) {
    storage::ScanArchiveOptions archive_options;
    archive_options.segment_bytes = options.segment_bytes;
    auto opened = storage::ScanArchive::Open(options.directory, archive_options);
    if (!opened.ok()) return opened.status();
    archive = *std::move(opened);
  }
  return std::unique_ptr<ScanRecorder>(
      new ScanRecorder(options, std::move(on_problem), std::move(archive), max_points));
}

ScanRecorder::ScanRecorder(const server::ArchiveOptions& options,
                           std::function<void(const std::string&)> on_problem,
                           std::unique_ptr<storage::ScanArchive> archive, uint64_t max_points)
    : options_(options),
      on_problem_(std::move(on_problem)),
      max_points_(max_points),
      archive_(std::move(archive)) {}

bool ScanRecorder::IsWorthKeeping(const PointPayload& payload) const {
  if (codec::PointCount(payload) > max_points_ || !codec::CheckLayout(payload).ok()) return false;
  if (payload.encoding == PayloadEncoding::kQuantized) return codec::Dequantize(payload).ok();
  for (const char* axis : {"x", "y", "z"}) {
    if (codec::FindField(payload, {axis}) == nullptr) return false;
  }
  return true;
}

absl::Status ScanRecorder::RecordScan(const SessionId& session, uint64_t last_sequence,
                                      const ScanUpload& scan) {
  if (!keeps()) return absl::OkStatus();
  {
    MutexLock lock(&mutex_);
    Kept& kept = kept_[session];
    kept.last_sequence = std::max(kept.last_sequence, last_sequence);
    if (scan.sequence != kept.last_sequence + 1) return absl::OkStatus();
  }
  if (!IsWorthKeeping(scan.payload)) {
    MutexLock lock(&mutex_);
    kept_[session].last_sequence = scan.sequence;
    return absl::OkStatus();
  }
  absl::Status status;
  if (options_.mode == server::ArchiveMode::kRounded) {
    const ScanUpload rounded{scan.sequence, scan.end_stamp_ns,
                             RoundScan(scan.payload, options_.resolution_m)};
    status = archive_->Append(session, rounded);
  } else {
    status = archive_->Append(session, scan);
  }
  if (absl::Status outcome = FollowUp(session, status, 1); !outcome.ok()) {
    return absl::ResourceExhaustedError(absl::StrCat(
        "the server cannot keep the scan and takes no more until it can (free space on its disk, "
        "then send again; or set archive.required: false): ",
        outcome.message()));
  }
  MutexLock lock(&mutex_);
  Kept& kept = kept_[session];
  kept.last_sequence = std::max(kept.last_sequence, scan.sequence);
  return absl::OkStatus();
}

absl::Status ScanRecorder::FollowUp(const SessionId& session, const absl::Status& status,
                                    uint64_t missing) {
  // A robot cannot do anything about a scan that is too large to be kept.
  const bool is_refused = options_.required && !absl::IsInvalidArgument(status);
  std::string first;
  {
    MutexLock lock(&mutex_);
    Kept& kept = kept_[session];
    if (status.ok()) {
      // Missing scans stay missing; a failure that was mended does not count.
      if (kept.missing == 0) kept.problem.clear();
      return absl::OkStatus();
    }
    if (!is_refused) kept.missing += missing;
    if (kept.problem.empty()) {
      first = absl::StrCat("scans of session ", session.value(),
                           " cannot be archived: ", status.message());
    }
    kept.problem = std::string(status.message());
  }
  if (on_problem_ && !first.empty()) on_problem_(first);
  return is_refused ? status : absl::OkStatus();
}

absl::Status ScanRecorder::Sync(const SessionId& session) {
  return keeps() ? FollowUp(session, archive_->Sync(session), 0) : absl::OkStatus();
}

absl::Status ScanRecorder::Finish(const SessionId& session) {
  return keeps() ? FollowUp(session, archive_->Finish(session), 0) : absl::OkStatus();
}

absl::Status ScanRecorder::Remove(const SessionId& session) {
  {
    MutexLock lock(&mutex_);
    kept_.erase(session);
  }
  return archive_ == nullptr ? absl::OkStatus() : archive_->Remove(session);
}

absl::Status ScanRecorder::FreeBytes(const SessionId& session, uint64_t bytes) {
  uint64_t freed = 0;
  while (archive_ != nullptr && freed < bytes) {
    const absl::StatusOr<uint64_t> more = archive_->RemoveOldestSegment(session);
    if (!more.ok()) return more.status();
    if (*more == 0) break;
    freed += *more;
  }
  return absl::OkStatus();
}

uint64_t ScanRecorder::Bytes(const SessionId& session) const {
  return archive_ == nullptr ? 0 : archive_->Bytes(session);
}

std::string ScanRecorder::Problem(const SessionId& session) const {
  MutexLock lock(&mutex_);
  const auto found = kept_.find(session);
  if (found == kept_.end() || found->second.problem.empty()) return "";
  const Kept& kept = found->second;
  if (kept.missing == 0) return absl::StrCat("scans cannot be archived: ", kept.problem);
  return absl::StrCat(kept.missing, " scans are missing in the archive: ", kept.problem);
}

}  // namespace isthmus::ingest
