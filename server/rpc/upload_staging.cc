#include "server/rpc/upload_staging.h"

#include <absl/strings/escaping.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <utility>
#include <vector>

namespace isthmus::rpc {
namespace {

constexpr char kSuffix[] = ".part";
constexpr char kMagic[] = "isthmus-upload-1";
constexpr uint64_t kSyncEvery = 4u << 20;
constexpr auto kStale = std::chrono::hours(7 * 24);

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
  std::ifstream file(path, std::ios::binary);
  std::string line;
  if (!std::getline(file, line)) return std::nullopt;
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

absl::Status Failure(const std::string& path) {
  const int code = errno;
  const std::string message = absl::StrCat("cannot write ", path, ": ", strerror(code));
  if (code == ENOSPC || code == EDQUOT) {
    return absl::ResourceExhaustedError(message + "; the server's disk is full: try again later");
  }
  return absl::UnavailableError(message);
}

// False, with errno, when not all of it could be written.
bool WriteAll(int file, const std::string& bytes, uint64_t offset) {
  for (size_t done = 0; done < bytes.size();) {
    const ssize_t n =
        pwrite(file, bytes.data() + done, bytes.size() - done, static_cast<off_t>(offset + done));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    done += static_cast<size_t>(n);
  }
  return true;
}

}  // namespace

UploadStaging::UploadStaging(std::string folder, uint64_t max_bytes)
    : folder_(std::move(folder)), max_bytes_(max_bytes) {
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
      entries_[key->id] = {*key, 0, {}};
    }
  }
  for (const auto& path : useless) std::filesystem::remove(path, error);
}

std::string UploadStaging::PathOf(const SubmapId& id) const {
  return absl::StrCat(folder_, "/", id.session.value(), "-", id.index, kSuffix);
}

absl::StatusOr<std::unique_ptr<UploadStaging::Part>> UploadStaging::Begin(const UploadKey& key) {
  MutexLock lock(&mutex_);
  uint64_t under_way = key.size;
  for (const auto& [id, entry] : entries_) {
    if (id.session == key.id.session && id != key.id) under_way += entry.key.size;
  }
  if (under_way > max_bytes_) {
    return absl::ResourceExhaustedError(
        absl::StrCat("session ", key.id.session.value(), " has uploads of ", under_way,
                     " bytes under way, more than ", max_bytes_, ": finish those first"));
  }
  if (const auto found = entries_.find(key.id); found != entries_.end()) {
    if (found->second.key != key) Forget(key.id);
  }
  Entry& entry = entries_[key.id];
  entry.key = key;
  entry.turn = ++turns_;
  std::unique_ptr<Part> part(new Part(*this, key));
  part->turn_ = entry.turn;
  part->data_ = std::exchange(entry.data, {});
  if (folder_.empty()) return part;
  if (absl::Status status = OpenFile(*part); !status.ok()) return status;
  return part;
}

absl::Status UploadStaging::OpenFile(Part& part) const {
  const std::string path = PathOf(part.key_.id);
  const std::string header = HeaderOf(part.key_);
  part.header_ = header.size();
  part.file_ = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (part.file_ < 0) return Failure(path);
  struct stat info = {};
  if (fstat(part.file_, &info) != 0) return Failure(path);
  const auto size = static_cast<uint64_t>(info.st_size);
  if (size < header.size())
    return WriteAll(part.file_, header, 0) ? absl::OkStatus() : Failure(path);
  part.data_.resize(std::min(size - header.size(), part.key_.size));
  size_t done = 0;
  while (done < part.data_.size()) {
    const ssize_t n = pread(part.file_, part.data_.data() + done, part.data_.size() - done,
                            static_cast<off_t>(header.size() + done));
    if (n <= 0) break;
    done += static_cast<size_t>(n);
  }
  part.data_.resize(done);
  return absl::OkStatus();
}

absl::Status UploadStaging::Part::Append(uint64_t offset, const std::string& bytes) {
  {
    MutexLock lock(&staging_.mutex_);
    const auto found = staging_.entries_.find(key_.id);
    if (found == staging_.entries_.end() || found->second.turn != turn_) {
      return absl::AbortedError("another call sends this submap");
    }
    data_.resize(std::min<uint64_t>(offset, data_.size()));
    if (file_ >= 0) {
      const uint64_t end = header_ + data_.size();
      bool written = ftruncate(file_, static_cast<off_t>(end)) == 0;
      written = written && WriteAll(file_, bytes, end);
      if (!written) {
        const absl::Status failure = Failure(staging_.PathOf(key_.id));
        if (ftruncate(file_, static_cast<off_t>(end)) != 0) staging_.Forget(key_.id);
        return failure;
      }
    }
    data_ += bytes;
  }
  unsynced_ += bytes.size();
  if (file_ < 0 || unsynced_ < kSyncEvery) return absl::OkStatus();
  unsynced_ = 0;
  return fdatasync(file_) == 0 ? absl::OkStatus() : Failure(staging_.PathOf(key_.id));
}

UploadStaging::Part::~Part() { staging_.Leave(*this); }

void UploadStaging::Leave(Part& part) {
  if (part.file_ >= 0) close(part.file_);
  MutexLock lock(&mutex_);
  const auto found = entries_.find(part.key_.id);
  if (found == entries_.end() || found->second.turn != part.turn_) return;
  if (folder_.empty()) found->second.data = std::move(part.data_);
}

uint64_t UploadStaging::Persisted(const UploadKey& key) {
  MutexLock lock(&mutex_);
  const auto found = entries_.find(key.id);
  if (found == entries_.end() || found->second.key != key) return 0;
  if (folder_.empty()) return found->second.data.size();
  const int file = open(PathOf(key.id).c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return 0;
  struct stat info = {};
  const bool safe = fdatasync(file) == 0 && fstat(file, &info) == 0;
  close(file);
  const uint64_t header = HeaderOf(key).size();
  const auto size = static_cast<uint64_t>(info.st_size);
  return safe && size > header ? std::min(size - header, key.size) : 0;
}

void UploadStaging::Forget(const SubmapId& id) {
  entries_.erase(id);
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
