#include "core/io/directory_lock.h"

#include <absl/strings/ascii.h>
#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

namespace isthmus::io {
namespace {

std::string ReadHolder(int descriptor) {
  char text[32] = {};
  const ssize_t size = pread(descriptor, text, sizeof(text) - 1, 0);
  if (size <= 0) return "unknown";
  return std::string(absl::StripAsciiWhitespace(std::string(text, static_cast<size_t>(size))));
}

// For whoever finds the folder locked; that it could not be written harms nothing.
void WriteHolder(int descriptor) {
  const std::string text = absl::StrCat(getpid(), "\n");
  if (ftruncate(descriptor, 0) == 0) {
    [[maybe_unused]] const ssize_t written = pwrite(descriptor, text.data(), text.size(), 0);
  }
}

absl::Status Lock(int descriptor, const std::string& directory) {
  if (flock(descriptor, LOCK_EX | LOCK_NB) == 0) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat("the map folder ", directory, " is in use by process ", ReadHolder(descriptor),
                   "; stop it, or choose another folder"));
}

}  // namespace

absl::StatusOr<std::unique_ptr<DirectoryLock>> DirectoryLock::Take(const std::string& directory) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error) {
    return absl::UnavailableError(
        absl::StrCat("cannot make the map folder ", directory, ": ", error.message()));
  }
  const std::string path = directory + "/isthmus.lock";
  const int descriptor = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor < 0) {
    return absl::FailedPreconditionError(
        absl::StrCat("cannot write to the map folder ", directory, ": ", strerror(errno)));
  }
  std::unique_ptr<DirectoryLock> lock(new DirectoryLock(descriptor));
  if (absl::Status status = Lock(descriptor, directory); !status.ok()) return status;
  WriteHolder(descriptor);
  return lock;
}

absl::StatusOr<std::unique_ptr<DirectoryLock>> DirectoryLock::TakeExisting(
    const std::string& directory) {
  const std::string path = directory + "/isthmus.lock";
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0 && errno != ENOENT) {
    return absl::FailedPreconditionError(
        absl::StrCat("cannot read the map folder ", directory, ": ", strerror(errno)));
  }
  std::unique_ptr<DirectoryLock> lock(new DirectoryLock(descriptor));
  if (descriptor < 0) return lock;
  if (absl::Status status = Lock(descriptor, directory); !status.ok()) return status;
  return lock;
}

DirectoryLock::~DirectoryLock() {
  if (descriptor_ >= 0) close(descriptor_);
}

}  // namespace isthmus::io
