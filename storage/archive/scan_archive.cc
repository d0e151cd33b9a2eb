#include "storage/archive/scan_archive.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <system_error>
#include <utility>

#include "core/io/folder.h"
#include "core/io/record_log.h"
#include "storage/archive/scan_record.h"
#include "storage/archive/scan_segment.h"

namespace isthmus::storage {
namespace {

namespace fs = std::filesystem;

uint64_t BytesOf(const std::string& folder) {
  uint64_t bytes = 0;
  for (const int number : ListSegments(folder)) {
    std::error_code error;
    const uint64_t size = fs::file_size(absl::StrCat(folder, "/", SegmentName(number)), error);
    if (!error) bytes += size;
  }
  return bytes;
}

// A session's name is that of its folder.
absl::Status CheckName(const SessionId& session) {
  const std::string& name = session.value();
  if (!name.empty() && name != "." && name != ".." && name.find('/') == std::string::npos &&
      name.find('\0') == std::string::npos) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat("the session \"", name, "\" cannot have an archive: its name is no folder's"));
}

}  // namespace

// The segments of one session, the last of which grows.
class ScanArchive::Session {
 public:
  Session(std::string folder, const ScanArchiveOptions& options)
      : folder_(std::move(folder)), options_(options), bytes_(BytesOf(folder_)) {}

  absl::Status Append(uint64_t sequence, int64_t end_stamp_ns, const std::string& body) {
    MutexLock lock(&mutex_);
    const uint64_t size = io::kRecordHeaderBytes + body.size();
    if (absl::Status status = Prepare(size); !status.ok()) return status;
    const auto added = io::AppendRecord(*file_, kScanMarker, sequence, end_stamp_ns, body);
    if (added.ok()) bytes_ += size;
    return added.status();
  }

  absl::Status Sync() {
    MutexLock lock(&mutex_);
    return SyncLocked();
  }

  absl::Status Finish() {
    MutexLock lock(&mutex_);
    absl::Status status = SyncLocked();
    if (status.ok()) file_ = nullptr;
    return status;
  }

  absl::Status Remove() {
    MutexLock lock(&mutex_);
    file_ = nullptr;
    std::error_code error;
    fs::remove_all(folder_, error);
    bytes_ = BytesOf(folder_);
    if (error) return io::FileError("remove", folder_, error.value());
    lost_ = absl::OkStatus();
    return absl::OkStatus();
  }

  absl::StatusOr<uint64_t> RemoveOldestSegment() {
    MutexLock lock(&mutex_);
    const std::vector<int> numbers = ListSegments(folder_);
    if (numbers.empty()) return 0;
    if (numbers.size() == 1) file_ = nullptr;  // It is the one that grows.
    const std::string path = PathOf(numbers.front());
    std::error_code error;
    const uint64_t size = fs::file_size(path, error);
    if (!error) fs::remove(path, error);
    if (error) return io::FileError("remove", path, error.value());
    bytes_ -= std::min(bytes_.load(), size);
    return size;
  }

  uint64_t bytes() const { return bytes_; }

 private:
  std::string PathOf(int number) const { return absl::StrCat(folder_, "/", SegmentName(number)); }

  absl::Status SyncLocked() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (!lost_.ok()) return lost_;
    if (file_ == nullptr) return absl::OkStatus();
    if (file_->is_suspect()) return Rescue();
    return file_->synced_size() == file_->size() ? absl::OkStatus() : file_->Sync();
  }

  // There is a file that takes `size` more bytes.
  absl::Status Prepare(uint64_t size) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (file_ == nullptr) {
      if (absl::Status status = GoOn(); !status.ok()) return status;
    }
    if (file_->is_suspect()) {
      if (absl::Status status = Rescue(); !status.ok()) return status;
    }
    const bool is_full =
        file_->size() > kSegmentHeadSize && file_->size() + size > options_.segment_bytes;
    if (!is_full && !file_->is_broken()) return absl::OkStatus();
    // Only the last segment may end unfinished.
    if (absl::Status status = SyncLocked(); !status.ok()) return status;
    return StartSegment();
  }

  // Opens the last segment, if there is one, and cuts off an unfinished end.
  absl::Status GoOn() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (absl::Status status = io::MakeFolder(folder_, options_.disk); !status.ok()) return status;
    const std::vector<int> numbers = ListSegments(folder_);
    number_ = numbers.empty() ? 0 : numbers.back();
    if (numbers.empty()) return StartSegment();
    auto file = io::AppendFile::Open(PathOf(number_), options_.disk);
    if (!file.ok()) return file.status();
    const absl::StatusOr<io::RecordIndex> index = IndexSegment(**file, io::Look::kBodies);
    if (!index.ok()) return index.status();
    if (index->end < (*file)->size()) {
      if (absl::Status status = (*file)->Truncate(index->end); !status.ok()) return status;
    }
    if ((*file)->size() == 0) {
      if (absl::Status status = (*file)->Append(MakeSegmentHead()); !status.ok()) return status;
    }
    file_ = *std::move(file);
    bytes_ = BytesOf(folder_);
    return absl::OkStatus();
  }

  absl::Status StartSegment() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    auto file = io::AppendFile::Open(PathOf(number_ + 1), options_.disk);
    if (!file.ok()) return file.status();
    // A start that failed before may have left something.
    absl::Status status = (*file)->Truncate(0);
    if (status.ok()) status = (*file)->Append(MakeSegmentHead());
    if (status.ok()) status = io::SyncFolder(folder_, options_.disk);
    if (!status.ok()) return status;
    ++number_;
    file_ = *std::move(file);
    bytes_ += file_->size();
    return absl::OkStatus();
  }

  // After a sync that failed, the next one may say OK of data that the system has dropped. So the
  // part that was not synced is read back and, if it is still whole, written anew to another
  // segment.
  absl::Status Rescue() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    const std::shared_ptr<io::AppendFile> old = file_;
    const uint64_t from = std::max(old->synced_size(), kSegmentHeadSize);
    absl::StatusOr<std::string> bytes = old->Read(from, old->size() - from);
    if (!bytes.ok()) return bytes.status();
    const absl::StatusOr<io::RecordIndex> index = IndexSegment(*old, io::Look::kBodies);
    if (!index.ok()) return index.status();
    bool is_whole = index->end == old->size();
    for (const io::DamagedBytes& damaged : index->damaged) {
      is_whole = is_whole && damaged.offset + damaged.size <= from;
    }
    if (!is_whole) {
      lost_ = absl::DataLossError(
          absl::StrCat("the disk has lost scans that it had taken: ", old->path(),
                       "; start the server again, so that the robot sends them again"));
      return lost_;
    }
    if (absl::Status status = StartSegment(); !status.ok()) return status;
    absl::Status status = file_->Append(*bytes);
    if (status.ok()) status = file_->Sync();
    if (!status.ok()) {
      --number_;  // To be started again.
      bytes_ -= std::min(bytes_.load(), kSegmentHeadSize);
      file_ = old;
      return status;
    }
    // They lie there twice otherwise, which does no harm.
    bytes_ += bytes->size();
    if (old->Truncate(from).ok()) bytes_ -= bytes->size();
    return absl::OkStatus();
  }

  const std::string folder_;
  const ScanArchiveOptions& options_;
  std::atomic<uint64_t> bytes_;  // To be read while the disk is at work; changed under mutex_.
  Mutex mutex_;
  int number_ ABSL_GUARDED_BY(mutex_) = 0;  // Number of the segment that grows.
  // Null before the first scan and once finished.
  std::shared_ptr<io::AppendFile> file_ ABSL_GUARDED_BY(mutex_);
  absl::Status lost_ ABSL_GUARDED_BY(mutex_);  // The error that Sync returns for good.
};

absl::StatusOr<std::unique_ptr<ScanArchive>> ScanArchive::Open(const std::string& directory,
                                                               const ScanArchiveOptions& options) {
  return std::unique_ptr<ScanArchive>(new ScanArchive(absl::StrCat(directory, "/scans"), options));
}

ScanArchive::ScanArchive(std::string folder, const ScanArchiveOptions& options)
    : folder_(std::move(folder)), options_(options) {
  std::error_code error;
  for (fs::directory_iterator it(folder_, error), end; !error && it != end; it.increment(error)) {
    if (it->is_directory(error)) (void)Find(SessionId(it->path().filename().string()));
  }
}

ScanArchive::~ScanArchive() = default;

std::shared_ptr<ScanArchive::Session> ScanArchive::Find(const SessionId& session) {
  MutexLock lock(&mutex_);
  std::shared_ptr<Session>& found = sessions_[session];
  if (found == nullptr) {
    found = std::make_shared<Session>(absl::StrCat(folder_, "/", session.value()), options_);
  }
  return found;
}

absl::Status ScanArchive::Append(const SessionId& session, const ScanUpload& scan) {
  if (absl::Status status = CheckName(session); !status.ok()) return status;
  const absl::StatusOr<std::string> body = EncodeScan(scan);
  if (!body.ok()) return body.status();
  return Find(session)->Append(scan.sequence, scan.end_stamp_ns, *body);
}

absl::Status ScanArchive::Sync(const SessionId& session) {
  if (absl::Status status = CheckName(session); !status.ok()) return status;
  return Find(session)->Sync();
}

absl::Status ScanArchive::Finish(const SessionId& session) {
  if (absl::Status status = CheckName(session); !status.ok()) return status;
  return Find(session)->Finish();
}

absl::Status ScanArchive::Remove(const SessionId& session) {
  if (absl::Status status = CheckName(session); !status.ok()) return status;
  return Find(session)->Remove();
}

absl::StatusOr<uint64_t> ScanArchive::RemoveOldestSegment(const SessionId& session) {
  if (absl::Status status = CheckName(session); !status.ok()) return status;
  return Find(session)->RemoveOldestSegment();
}

uint64_t ScanArchive::Bytes(const SessionId& session) const {
  MutexLock lock(&mutex_);
  const auto found = sessions_.find(session);
  return found == sessions_.end() ? 0 : found->second->bytes();
}

}  // namespace isthmus::storage
