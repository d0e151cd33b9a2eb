#include "server/rpc/watched_keys.h"

#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <utility>

#include "core/concurrency/thread_role.h"
#include "server/rpc/streams/limits.h"

namespace isthmus::rpc {
namespace {

// Has `*file` be a file in memory with that text: whoever opens it sees the old text or this one.
absl::Status Replace(const std::string& text, int* file) {
  const int made = memfd_create("isthmus-keys", MFD_CLOEXEC);
  if (made < 0) return absl::ErrnoToStatus(errno, "a file in memory cannot be made");
  if (write(made, text.data(), text.size()) != static_cast<ssize_t>(text.size())) {
    const absl::Status status = absl::ErrnoToStatus(errno, "a file in memory cannot be written");
    close(made);
    return status;
  }
  if (*file < 0) {
    *file = made;
    return absl::OkStatus();
  }
  const int put = dup3(made, *file, O_CLOEXEC);
  const absl::Status status =
      put < 0 ? absl::ErrnoToStatus(errno, "a file in memory cannot be replaced") : absl::Status();
  close(made);
  return status;
}

}  // namespace

WatchedKeys::WatchedKeys(const tls::KeyFiles& files, std::string stamp)
    : files_(files), stamp_(std::move(stamp)) {}

absl::StatusOr<std::unique_ptr<WatchedKeys>> WatchedKeys::Open(const tls::KeyFiles& files) {
  std::unique_ptr<WatchedKeys> keys(new WatchedKeys(files, tls::StampOf(files)));
  const auto texts = tls::ReadKeyFiles(files);
  if (!texts.ok()) return texts.status();
  if (absl::Status status = keys->Put(*texts); !status.ok()) return status;
  keys->following_ = std::thread([watched = keys.get()] { watched->Follow(); });
  return keys;
}

WatchedKeys::~WatchedKeys() {
  {
    MutexLock lock(&mutex_);
    is_ending_ = true;
    changed_.SignalAll();
  }
  if (following_.joinable()) following_.join();
}

std::string WatchedKeys::PathOf(int file) {
  return file < 0 ? "" : absl::StrCat("/proc/self/fd/", file);
}

absl::Status WatchedKeys::Put(const tls::KeyTexts& texts) {
  absl::Status status = Replace(absl::StrCat(texts.key, "\n", texts.certificate), &pair_);
  if (status.ok() && !texts.client_ca.empty()) status = Replace(texts.client_ca, &client_ca_);
  return status;
}

void WatchedKeys::Follow() {
  NameThread("key_files");
  MutexLock lock(&mutex_);
  while (!is_ending_) {
    changed_.WaitFor(&mutex_, std::chrono::seconds(kCertificateReloadS));
    std::string stamp = tls::StampOf(files_);
    if (stamp == stamp_) continue;
    const auto texts = tls::ReadKeyFiles(files_);
    // Half written, or wrong: the rest will be seen too, and what is wrong is warned of elsewhere.
    if (!texts.ok() || Put(*texts).ok()) stamp_ = std::move(stamp);
  }
}

}  // namespace isthmus::rpc
