#include "core/io/directory_lock.h"

#include <absl/strings/ascii.h>
#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <utility>

#include "core/io/folder.h"

namespace isthmus::io {
namespace {

std::string ReadHolder(const File& file) {
  std::string text(32, '\0');
  const absl::StatusOr<size_t> size = file.Read(text.data(), text.size(), 0);
  if (!size.ok() || *size == 0) return "unknown";
  return std::string(absl::StripAsciiWhitespace(text.substr(0, *size)));
}

// For whoever finds the folder locked; that it could not be written harms nothing.
void WriteHolder(const File& file) {
  const std::string text = absl::StrCat(getpid(), "\n");
  if (file.Truncate(0).ok()) (void)file.Write(text.data(), text.size(), 0);
}

absl::Status Lock(const File& file, const std::string& folder) {
  if (flock(file.descriptor(), LOCK_EX | LOCK_NB) == 0) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat(
      folder, " is in use by process ", ReadHolder(file), "; stop it, or choose another folder"));
}

}  // namespace

absl::StatusOr<std::unique_ptr<DirectoryLock>> DirectoryLock::Acquire(const std::string& directory,
                                                                      const LockKind& kind) {
  const std::string folder = absl::StrCat(kind.name, " ", directory);
  const auto failed = [&](const absl::Status& why) {
    return absl::FailedPreconditionError(
        absl::StrCat("cannot use ", folder, ": ", why.message(), ", or choose another folder"));
  };
  if (absl::Status status = MakeFolder(directory); !status.ok()) return failed(status);
  absl::StatusOr<File> file = File::Open(directory + "/" + kind.file, O_RDWR | O_CREAT);
  if (!file.ok()) return failed(file.status());
  if (absl::Status status = Lock(*file, folder); !status.ok()) return status;
  WriteHolder(*file);
  return std::unique_ptr<DirectoryLock>(new DirectoryLock(*std::move(file)));
}

absl::StatusOr<std::unique_ptr<DirectoryLock>> DirectoryLock::TakeExisting(
    const std::string& directory) {
  const LockKind kind;
  const std::string folder = absl::StrCat(kind.name, " ", directory);
  absl::StatusOr<File> file = File::Open(directory + "/" + kind.file, O_RDONLY);
  if (absl::IsNotFound(file.status())) file = File();
  if (!file.ok()) {
    return absl::FailedPreconditionError(
        absl::StrCat("cannot read ", folder, ": ", file.status().message()));
  }
  if (file->is_open()) {
    if (absl::Status status = Lock(*file, folder); !status.ok()) return status;
  }
  return std::unique_ptr<DirectoryLock>(new DirectoryLock(*std::move(file)));
}

}  // namespace isthmus::io
