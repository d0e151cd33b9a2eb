#include "server/rpc/upload_staging.h"

#include <absl/strings/escaping.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include "core/io/sha256.h"

namespace isthmus::rpc {
namespace {

constexpr char kSuffix[] = ".part";
constexpr char kMagic[] = "isthmus-upload-1";
constexpr size_t kMaxHeader = 256;
constexpr uint64_t kSyncEvery = 4u << 20;
constexpr auto kStale = std::chrono::hours(7 * 24);
// A client sends one after the other; some may stay unfinished.
constexpr size_t kMaxParts = 16;

std::string HeaderOf(const UploadKey& key) {
  return absl::StrCat(kMagic, " ", key.size, " ", key.crc32c, " ",
                      absl::BytesToHexString(key.sha256), "\n");
}

// From a file's name, SESSION-INDEX.part, and its first line.
std::optional<UploadKey> ReadKey(const std::filesystem::path& path) {
  UploadKey key;
  const std::string name = path.stem().string();
  const size_t dash = name.rfind('-');
  if (dash == std::string::npos || !absl::SimpleAtoi(name.substr(dash + 1), &key.id.index)) {
    return std::nullopt;
  }
  key.id.session = SessionId(name.substr(0, dash));
  const auto file = io::AppendFile::OpenToRead(path.string());
  if (!file.ok()) return std::nullopt;
  const absl::StatusOr<std::string> begin = (*file)->Read(0, kMaxHeader);
  if (!begin.ok()) return std::nullopt;
  const std::string line = begin->substr(0, begin->find('\n'));
  const std::vector<std::string> words = absl::StrSplit(line, ' ');
  if (words.size() != 4 || words[0] != kMagic || !absl::SimpleAtoi(words[1], &key.size) ||
      !absl::SimpleAtoi(words[2], &key.crc32c)) {
    return std::nullopt;
  }
  key.sha256 = absl::HexStringToBytes(words[3]);
  // A damaged line does not tell which upload it names.
  if (HeaderOf(key) != line + "\n") return std::nullopt;
  return key;
}

// The error of this machine's disk as a robot is told it: full, or to be tried again.
absl::Status Told(const absl::Status& status) {
  if (status.ok() || absl::IsResourceExhausted(status)) return status;
  return absl::UnavailableError(status.message());
}

}  // namespace

absl::Status TakenOver() { return absl::AbortedError("another call sends this submap"); }

absl::Status CheckSha256(const std::string& sha256) {
  if (sha256.empty() || sha256.size() == io::kSha256Bytes) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("a sha256 of ", sha256.size(), " bytes: give its 32 bytes, or none"));
}

UploadStaging::UploadStaging(std::string folder, uint64_t max_bytes, const Clock& clock)
    : folder_(std::move(folder)), max_bytes_(max_bytes), clock_(clock) {
  if (!folder_.empty()) Load();
}

void UploadStaging::Load() {
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  std::vector<std::filesystem::path> useless;
  for (const auto& file : std::filesystem::directory_iterator(folder_, error)) {
    if (file.path().extension() != kSuffix) continue;
    const auto age = std::filesystem::file_time_type::clock::now() - file.last_write_time(error);
    std::optional<UploadKey> key = ReadKey(file.path());
    if (error || !key || age > kStale) {
      useless.push_back(file.path());
    } else {
      const int64_t age_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(age).count();
      Entry& entry = entries_[key->id];
      entry.key = *key;
      entry.touched_ns = clock_.NowNs() - age_ns;
    }
  }
  under_way_ = entries_.size();
  for (const auto& path : useless) std::filesystem::remove(path, error);
}

std::string UploadStaging::PathOf(const SubmapId& id) const {
  return absl::StrCat(folder_, "/", id.session.value(), "-", id.index, kSuffix);
}

absl::Status UploadStaging::CheckRoom(const UploadKey& key) const {
  uint64_t under_way = key.size;
  size_t parts = 1;
  for (const auto& [id, entry] : entries_) {
    if (id.session != key.id.session || id == key.id) continue;
    under_way += entry.key.size;
    ++parts;
  }
  if (under_way > max_bytes_) {
    return absl::ResourceExhaustedError(
        absl::StrCat("session ", key.id.session.value(), " has uploads of ", under_way,
                     " bytes under way, more than ", max_bytes_, ": finish those first"));
  }
  if (parts > kMaxParts) {
    return absl::ResourceExhaustedError(
        absl::StrCat("session ", key.id.session.value(), " has ", kMaxParts,
                     " uploads under way, as many as it may: finish those first"));
  }
  return absl::OkStatus();
}

void UploadStaging::ForgetStale() {
  const int64_t kept_ns =
      clock_.NowNs() - std::chrono::duration_cast<std::chrono::nanoseconds>(kStale).count();
  std::vector<SubmapId> stale;
  for (const auto& [id, entry] : entries_) {
    if (entry.touched_ns < kept_ns) stale.push_back(id);
  }
  for (const SubmapId& id : stale) Forget(id);
}

absl::StatusOr<std::unique_ptr<UploadStaging::Part>> UploadStaging::BeginUpload(
    const UploadKey& key, std::function<void()> taken_over) {
  if (absl::Status status = CheckSha256(key.sha256); !status.ok()) return status;
  MutexLock lock(&mutex_);
  ForgetStale();
  if (absl::Status status = CheckRoom(key); !status.ok()) return status;
  if (const auto found = entries_.find(key.id); found != entries_.end()) {
    if (found->second.taken_over) found->second.taken_over();
    if (found->second.key != key) Forget(key.id);
  }
  Entry& entry = entries_[key.id];
  under_way_ = entries_.size();
  entry.key = key;
  entry.turn = ++turns_;
  entry.touched_ns = clock_.NowNs();
  entry.taken_over = std::move(taken_over);
  std::unique_ptr<Part> part(new Part(*this, key));
  part->turn_ = entry.turn;
  part->data_ = std::exchange(entry.data, {});
  part->size_ = part->data_.size();
  if (folder_.empty()) return part;
  absl::Status status = OpenFile(*part);
  if (status.ok()) return part;
  entry.taken_over = nullptr;
  part->turn_ = 0;  // It goes with the lock held: nothing is released.
  return Told(status);
}

absl::Status UploadStaging::OpenFile(Part& part) const {
  const std::string header = HeaderOf(part.key_);
  part.header_ = header.size();
  auto file = io::AppendFile::Open(PathOf(part.key_.id));
  if (!file.ok()) return file.status();
  part.file_ = *std::move(file);
  if (part.file_->size() < header.size()) {
    const absl::Status status = part.file_->Truncate(0);
    return status.ok() ? part.file_->Append(header) : status;
  }
  part.size_ = std::min(part.file_->size() - header.size(), part.key_.size);
  return absl::OkStatus();
}

absl::Status UploadStaging::Part::CheckTurn() const {
  const auto found = staging_.entries_.find(key_.id);
  if (found == staging_.entries_.end() || found->second.turn != turn_) return TakenOver();
  return absl::OkStatus();
}

absl::Status UploadStaging::Part::Append(uint64_t offset, const std::string& bytes) {
  {
    MutexLock lock(&staging_.mutex_);
    if (absl::Status status = CheckTurn(); !status.ok()) return status;
    staging_.entries_[key_.id].touched_ns = staging_.clock_.NowNs();
    const uint64_t kept = std::min<uint64_t>(offset, size_);
    if (file_ == nullptr) {
      data_.resize(kept);
      data_ += bytes;
    } else {
      const uint64_t end = header_ + kept;
      absl::Status status = file_->Truncate(end);
      if (status.ok()) status = file_->Append(bytes);
      if (!status.ok()) {
        size_ = kept;
        if (!file_->Truncate(end).ok()) staging_.Forget(key_.id);
        return Told(status);
      }
    }
    size_ = kept + bytes.size();
  }
  unsynced_ += bytes.size();
  if (file_ == nullptr || unsynced_ < kSyncEvery) return absl::OkStatus();
  unsynced_ = 0;
  return Told(file_->Sync());
}

absl::StatusOr<std::string> UploadStaging::Part::TakeData() {
  MutexLock lock(&staging_.mutex_);
  if (absl::Status status = CheckTurn(); !status.ok()) return status;
  if (file_ == nullptr) {
    size_ = 0;
    return std::move(data_);
  }
  absl::StatusOr<std::string> data = file_->Read(header_, size_);
  if (!data.ok()) return Told(data.status());
  return data;
}

UploadStaging::Part::~Part() {
  if (turn_ != 0) staging_.ReleasePart(*this);
}

void UploadStaging::ReleasePart(Part& part) {
  MutexLock lock(&mutex_);
  const auto found = entries_.find(part.key_.id);
  if (found == entries_.end() || found->second.turn != part.turn_) return;
  found->second.taken_over = nullptr;
  if (folder_.empty()) found->second.data = std::move(part.data_);
}

uint64_t UploadStaging::Persisted(const UploadKey& key) {
  MutexLock lock(&mutex_);
  const auto found = entries_.find(key.id);
  if (found == entries_.end() || found->second.key != key) return 0;
  if (folder_.empty()) return found->second.data.size();
  const auto file = io::AppendFile::OpenToRead(PathOf(key.id));
  const uint64_t header = HeaderOf(key).size();
  if (!file.ok() || !(*file)->Sync().ok() || (*file)->size() < header) return 0;
  return std::min((*file)->size() - header, key.size);
}

void UploadStaging::Forget(const SubmapId& id) {
  entries_.erase(id);
  under_way_ = entries_.size();
  if (!folder_.empty()) unlink(PathOf(id).c_str());
}

void UploadStaging::Drop(const SubmapId& id) {
  MutexLock lock(&mutex_);
  if (entries_.count(id) != 0) Forget(id);
}

void UploadStaging::DropSession(const SessionId& session) {
  MutexLock lock(&mutex_);
  std::vector<SubmapId> ids;
  for (const auto& [id, entry] : entries_) {
    if (id.session == session) ids.push_back(id);
  }
  for (const SubmapId& id : ids) Forget(id);
}

}  // namespace isthmus::rpc
