#include "client/library/spool_folder.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <map>
#include <system_error>

namespace isthmus::client {

absl::StatusOr<std::unique_ptr<SpoolFolder>> SpoolFolder::Open(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  const std::string file = path + "/lock";
  const int lock = error ? -1 : open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (lock < 0) {
    return absl::FailedPreconditionError(
        absl::StrCat("cannot write to the spool ", path, ": ",
                     error ? error.message() : std::string(strerror(errno)),
                     "; give this user the right to, or name another folder"));
  }
  std::unique_ptr<SpoolFolder> folder(new SpoolFolder(path, lock));
  if (flock(lock, LOCK_EX | LOCK_NB) == 0) return folder;
  return absl::FailedPreconditionError(absl::StrCat(
      "the spool ", path, " is in use by another program; stop it, or name another folder"));
}

SpoolFolder::~SpoolFolder() { close(lock_); }

absl::StatusOr<std::vector<std::unique_ptr<SessionSpool>>> SpoolFolder::Load(
    const SessionSpool::Options& options) {
  std::map<int, std::string> numbered;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(path_, error)) {
    int number = 0;
    if (!absl::SimpleAtoi(entry.path().filename().string(), &number)) continue;
    numbered[number] = entry.path().string();
  }
  if (error) return absl::UnavailableError(absl::StrCat(path_, ": ", error.message()));
  std::vector<std::unique_ptr<SessionSpool>> spools;
  for (const auto& [number, path] : numbered) {
    newest_ = number;
    auto spool = SessionSpool::Open(path, options);
    if (spool.ok()) {
      spools.push_back(*std::move(spool));
    } else if (absl::IsNotFound(spool.status())) {
      // The program died while it made or removed it: no scan is in it that is still needed.
      std::filesystem::remove_all(path, error);
    } else {
      return spool.status();
    }
  }
  return spools;
}

absl::StatusOr<std::unique_ptr<SessionSpool>> SpoolFolder::Add(
    const SpoolIdentity& identity, const SessionSpool::Options& options) {
  const std::string path = absl::StrFormat("%s/%06d", path_, ++newest_);
  return SessionSpool::Create(path, identity, options);
}

}  // namespace isthmus::client
