#include "tests/storage/power_cut_disk.h"

#include <sqlite3.h>

#include <algorithm>
#include <filesystem>

#include "core/io/file_io.h"

namespace isthmus::storage {
namespace {

PowerCutDisk* disk = nullptr;
sqlite3_vfs* under = nullptr;  // The system's.
sqlite3_vfs vfs;

// The system's file lies behind it in memory.
struct DiskFile {
  sqlite3_file base;
  const char* path;  // SQLite's, alive while the file is open; null for temporary files.
};

sqlite3_file* Under(sqlite3_file* file) {
  return reinterpret_cast<sqlite3_file*>(reinterpret_cast<DiskFile*>(file) + 1);
}
const char* PathOf(sqlite3_file* file) { return reinterpret_cast<DiskFile*>(file)->path; }

int Close(sqlite3_file* file) { return Under(file)->pMethods->xClose(Under(file)); }
int Read(sqlite3_file* file, void* data, int size, sqlite3_int64 offset) {
  return Under(file)->pMethods->xRead(Under(file), data, size, offset);
}
int Write(sqlite3_file* file, const void* data, int size, sqlite3_int64 offset) {
  if (PathOf(file) != nullptr) {
    if (!disk->TryOperation()) return SQLITE_IOERR_WRITE;
    disk->Write(PathOf(file), static_cast<const char*>(data), static_cast<size_t>(size), offset);
  }
  return Under(file)->pMethods->xWrite(Under(file), data, size, offset);
}
int Truncate(sqlite3_file* file, sqlite3_int64 size) {
  if (PathOf(file) != nullptr) {
    if (!disk->TryOperation()) return SQLITE_IOERR_TRUNCATE;
    disk->Truncate(PathOf(file), size);
  }
  return Under(file)->pMethods->xTruncate(Under(file), size);
}
int Sync(sqlite3_file* file, int) {
  if (PathOf(file) == nullptr) return SQLITE_OK;
  if (!disk->TryOperation()) return SQLITE_IOERR_FSYNC;
  disk->Sync(PathOf(file));
  return SQLITE_OK;  // The real disk is not what is tried.
}
int FileSize(sqlite3_file* file, sqlite3_int64* size) {
  return Under(file)->pMethods->xFileSize(Under(file), size);
}
int Lock(sqlite3_file* file, int lock) { return Under(file)->pMethods->xLock(Under(file), lock); }
int Unlock(sqlite3_file* file, int lock) {
  return Under(file)->pMethods->xUnlock(Under(file), lock);
}
int CheckReservedLock(sqlite3_file* file, int* result) {
  return Under(file)->pMethods->xCheckReservedLock(Under(file), result);
}
int FileControl(sqlite3_file* file, int what, void* argument) {
  return Under(file)->pMethods->xFileControl(Under(file), what, argument);
}
int SectorSize(sqlite3_file* file) { return Under(file)->pMethods->xSectorSize(Under(file)); }
int Characteristics(sqlite3_file* file) {
  return Under(file)->pMethods->xDeviceCharacteristics(Under(file));
}
int ShmMap(sqlite3_file* file, int page, int size, int extend, void volatile** memory) {
  return Under(file)->pMethods->xShmMap(Under(file), page, size, extend, memory);
}
int ShmLock(sqlite3_file* file, int offset, int count, int flags) {
  return Under(file)->pMethods->xShmLock(Under(file), offset, count, flags);
}
void ShmBarrier(sqlite3_file* file) { Under(file)->pMethods->xShmBarrier(Under(file)); }
int ShmUnmap(sqlite3_file* file, int remove) {
  return Under(file)->pMethods->xShmUnmap(Under(file), remove);
}

const sqlite3_io_methods kMethods = {2,
                                     Close,
                                     Read,
                                     Write,
                                     Truncate,
                                     Sync,
                                     FileSize,
                                     Lock,
                                     Unlock,
                                     CheckReservedLock,
                                     FileControl,
                                     SectorSize,
                                     Characteristics,
                                     ShmMap,
                                     ShmLock,
                                     ShmBarrier,
                                     ShmUnmap,
                                     nullptr,
                                     nullptr};

int OpenFile(sqlite3_vfs*, const char* path, sqlite3_file* file, int flags, int* flags_got) {
  file->pMethods = nullptr;
  const int code = under->xOpen(under, path, Under(file), flags, flags_got);
  if (code != SQLITE_OK) return code;
  constexpr int kKept = SQLITE_OPEN_MAIN_DB | SQLITE_OPEN_MAIN_JOURNAL | SQLITE_OPEN_WAL;
  reinterpret_cast<DiskFile*>(file)->path = (flags & kKept) != 0 ? path : nullptr;
  if (PathOf(file) != nullptr) disk->Open(path);
  file->pMethods = &kMethods;
  return SQLITE_OK;
}

int DeleteFile(sqlite3_vfs*, const char* path, int sync) {
  if (!disk->TryOperation()) return SQLITE_IOERR_DELETE;
  disk->Delete(path);
  return under->xDelete(under, path, sync);
}

}  // namespace

PowerCutDisk::PowerCutDisk(uint32_t seed) : random_(seed) {
  disk = this;
  under = sqlite3_vfs_find(nullptr);
  vfs = *under;
  vfs.pNext = nullptr;
  vfs.zName = "power-cut";
  vfs.szOsFile = static_cast<int>(sizeof(DiskFile)) + under->szOsFile;
  vfs.xOpen = OpenFile;
  vfs.xDelete = DeleteFile;
  sqlite3_vfs_register(&vfs, 1);
}

PowerCutDisk::~PowerCutDisk() {
  sqlite3_vfs_unregister(&vfs);
  sqlite3_vfs_register(under, 1);
}

void PowerCutDisk::CutAfter(int64_t operations) {
  MutexLock lock(&mutex_);
  operations_left_ = operations;
}

bool PowerCutDisk::is_off() const {
  MutexLock lock(&mutex_);
  return is_off_;
}

void PowerCutDisk::Forget() {
  MutexLock lock(&mutex_);
  files_.clear();
}

int64_t PowerCutDisk::lost_writes() const {
  MutexLock lock(&mutex_);
  return lost_writes_;
}

bool PowerCutDisk::TryOperation() {
  MutexLock lock(&mutex_);
  if (operations_left_ == 0) is_off_ = true;
  if (operations_left_ > 0) --operations_left_;
  return !is_off_;
}

void PowerCutDisk::Open(const std::string& path) {
  MutexLock lock(&mutex_);
  if (files_.count(path) > 0) return;
  const auto bytes = io::ReadFile(path);
  files_[path].synced = bytes.ok() ? *bytes : std::string();
}

void PowerCutDisk::Write(const std::string& path, const char* data, size_t size, int64_t offset) {
  MutexLock lock(&mutex_);
  files_[path].pending.push_back({false, offset, std::string(data, size)});
}

void PowerCutDisk::Truncate(const std::string& path, int64_t size) {
  MutexLock lock(&mutex_);
  files_[path].pending.push_back({true, size, {}});
}

void PowerCutDisk::Sync(const std::string& path) {
  MutexLock lock(&mutex_);
  File& file = files_[path];
  for (const Change& change : file.pending) Apply(change, file.synced);
  file.pending.clear();
}

void PowerCutDisk::Delete(const std::string& path) {
  MutexLock lock(&mutex_);
  files_.erase(path);
}

void PowerCutDisk::Restore() {
  MutexLock lock(&mutex_);
  for (auto& [path, file] : files_) {
    for (const Change& change : file.pending) Survive(change, file);
    file.pending.clear();
    io::WriteFile(path, file.synced).IgnoreError();
    std::filesystem::remove(path + "-shm");  // Memory.
  }
  is_off_ = false;
  operations_left_ = -1;
}

void PowerCutDisk::Survive(const Change& change, File& file) {
  constexpr size_t kSector = 512;
  if (Coin()) {
    ++lost_writes_;
    if (change.is_truncation || Coin()) return;
    for (size_t begin = 0; begin < change.data.size(); begin += kSector) {
      const auto offset = change.offset + static_cast<int64_t>(begin);
      if (Coin()) Apply({false, offset, change.data.substr(begin, kSector)}, file.synced);
    }
    return;
  }
  Apply(change, file.synced);
}

void PowerCutDisk::Apply(const Change& change, std::string& bytes) {
  const auto offset = static_cast<size_t>(change.offset);
  if (change.is_truncation) {
    bytes.resize(std::min(offset, bytes.size()));
    return;
  }
  bytes.resize(std::max(bytes.size(), offset + change.data.size()));
  bytes.replace(offset, change.data.size(), change.data);
}

}  // namespace isthmus::storage
