// Keys and certificates as they were last good, for gRPC to watch.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <string>
#include <thread>

#include "core/concurrency/mutex.h"
#include "core/tls/key_files.h"

namespace isthmus::rpc {

// gRPC 1.51 ends the process where a file of keys that it watches is empty, and takes a certificate
// with another one's key, with which nobody gets in. So it watches what this keeps in memory: the
// content of the files, which follows theirs where that is good as a whole.
class WatchedKeys {
 public:
  // Looks at the files once a second, by a thread. Errors of tls::ReadKeyFiles.
  static absl::StatusOr<std::unique_ptr<WatchedKeys>> Open(const tls::KeyFiles& files);
  ~WatchedKeys();

  // Paths of the certificate with its key, in one file so that they change as one, and of the
  // clients' authority. Their content stays when this is gone: gRPC's thread may look once more.
  std::string pair_path() const { return PathOf(pair_); }
  std::string client_ca_path() const { return PathOf(client_ca_); }

 private:
  WatchedKeys(const tls::KeyFiles& files, std::string stamp);
  static std::string PathOf(int file);
  absl::Status Put(const tls::KeyTexts& texts);
  void Follow();

  const tls::KeyFiles files_;
  std::string stamp_;  // The files' stamp at the last look.
  int pair_ = -1, client_ca_ = -1;
  Mutex mutex_;
  CondVar changed_;
  bool is_ending_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread following_;
};

}  // namespace isthmus::rpc
