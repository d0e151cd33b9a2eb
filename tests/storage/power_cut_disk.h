// A disk whose power fails at a moment of the test's choice.
#pragma once

#include <cstdint>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "core/concurrency/mutex.h"

namespace isthmus::storage {

// While it lives, all of SQLite's files are on this disk: it is SQLite's default VFS, laid over the
// system's. One at a time. Thread safe.
//
// Written bytes may be read back at once, as from the system's cache, but are certain to survive
// only when they were synced. At a power cut each other write survives or does not, in no order,
// and sectors of 512 bytes of a write by themselves: writes are torn. Files that were made or
// deleted are taken to be so at once.
class PowerCutDisk {
 public:
  explicit PowerCutDisk(uint32_t seed);
  ~PowerCutDisk();
  PowerCutDisk(const PowerCutDisk&) = delete;
  PowerCutDisk& operator=(const PowerCutDisk&) = delete;

  // The power fails at the next but `operations` write, sync, truncation or deletion; from then on
  // each of them gives an error.
  void CutAfter(int64_t operations);
  bool is_off() const;
  // Puts what survived into the files and the power on again. Nothing may have files open.
  void Restore();
  // The files were removed by another hand.
  void Forget();
  // Writes that did not survive, or not wholly, in all power cuts so far.
  int64_t lost_writes() const;

  // For the VFS.
  bool TryOperation();  // False: the power is off.
  void Open(const std::string& path);
  void Write(const std::string& path, const char* data, size_t size, int64_t offset);
  void Truncate(const std::string& path, int64_t size);
  void Sync(const std::string& path);
  void Delete(const std::string& path);

 private:
  struct Change {
    bool is_truncation = false;
    int64_t offset = 0;  // The size, for a truncation.
    std::string data;
  };
  struct File {
    std::string synced;
    std::vector<Change> pending;
  };
  bool Coin() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return random_() % 2 == 0; }
  void Survive(const Change& change, File& file) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  static void Apply(const Change& change, std::string& bytes);

  mutable Mutex mutex_;
  std::mt19937 random_ ABSL_GUARDED_BY(mutex_);
  std::map<std::string, File> files_ ABSL_GUARDED_BY(mutex_);  // By path.
  int64_t operations_left_ ABSL_GUARDED_BY(mutex_) = -1;       // Negative: no end.
  bool is_off_ ABSL_GUARDED_BY(mutex_) = false;
  int64_t lost_writes_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace isthmus::storage
