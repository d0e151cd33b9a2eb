#include "core/io/directory_lock.h"

#include <absl/strings/ascii.h>
#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "core/io/folder.h"

namespace isthmus::io {
namespace {

std::string ReadHolder(const std::string& path) {
  const absl::StatusOr<File> file = File::Open(path, O_RDONLY);
  if (!file.ok()) return "unknown";
  std::string text(32, '\0');
  const absl::StatusOr<size_t> size = file->Read(text.data(), text.size(), 0);
  if (!size.ok() || *size == 0) return "unknown";
  return std::string(absl::StripAsciiWhitespace(text.substr(0, *size)));
}

// For whoever finds the folder locked; that it could not be written harms nothing.
void WriteHolder(const File& file) {
  const std::string text = absl::StrCat(getpid(), "\n");
  if (file.Truncate(0).ok()) (void)file.Write(text.data(), text.size(), 0);
}

bool IsAnothers(const File& file) {
  return flock(file.descriptor(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
}

absl::Status InUse(const std::string& folder, const std::string& path) {
  return absl::FailedPreconditionError(absl::StrCat(
      folder, " is in use by process ", ReadHolder(path), "; stop it, or choose another folder"));
}

}  // namespace

absl::StatusOr<std::unique_ptr<DirectoryLock>> DirectoryLock::Acquire(const std::string& directory,
                                                                      const LockKind& kind) {
  const std::string folder = absl::StrCat(kind.name, " ", directory);
  const auto failed = [&](const absl::Status& why) {
    return absl::FailedPreconditionError(
        absl::StrCat("cannot use ", folder, ": ", why.message(), "; choose another folder"));
  };
  if (absl::Status status = MakeFolder(directory); !status.ok()) return failed(status);
  const std::string path = directory + "/" + kind.file;
  absl::StatusOr<File> itself = File::Open(directory, O_RDONLY | O_DIRECTORY);
  if (!itself.ok()) return failed(itself.status());
  if (IsAnothers(*itself)) return InUse(folder, path);
  absl::StatusOr<File> file = File::Open(path, O_RDWR | O_CREAT);
  if (!file.ok()) return failed(file.status());
  if (IsAnothers(*file)) return InUse(folder, path);
  WriteHolder(*file);
  return std::unique_ptr<DirectoryLock>(new DirectoryLock(*std::move(itself), *std::move(file)));
}

absl::StatusOr<std::unique_ptr<DirectoryLock>> DirectoryLock::TakeExisting(
    const std::string& directory) {
  const LockKind kind;
  const std::string folder = absl::StrCat(kind.name, " ", directory);
  const std::string path = directory + "/" + kind.file;
  absl::StatusOr<File> itself = File::Open(directory, O_RDONLY | O_DIRECTORY);
  absl::StatusOr<File> file = File::Open(path, O_RDONLY);
  if (absl::IsNotFound(file.status())) file = File();
  for (const auto* opened : {&itself, &file}) {
    if (!opened->ok()) {
      return absl::FailedPreconditionError(
          absl::StrCat("cannot read ", folder, ": ", opened->status().message()));
    }
    if ((*opened)->is_open() && IsAnothers(**opened)) return InUse(folder, path);
  }
  return std::unique_ptr<DirectoryLock>(new DirectoryLock(*std::move(itself), *std::move(file)));
}

}  // namespace isthmus::io
