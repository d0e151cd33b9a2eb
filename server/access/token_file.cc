#include "server/access/token_file.h"

#include <absl/cleanup/cleanup.h>
#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

#include "core/io/file_io.h"
#include "core/io/folder.h"

namespace isthmus::access {
namespace {

constexpr mode_t kOwnerAlone = 0600;

// Root, who makes the first token, must not take the file away from the user that the server runs
// as: it is given to the owner of the folder.
absl::Status KeepPrivate(const io::File& file, const std::string& folder) {
  struct stat owner = {};
  if (fchmod(file.descriptor(), kOwnerAlone) != 0 || stat(folder.c_str(), &owner) != 0) {
    return io::FileError("protect", file.path(), errno);
  }
  if (geteuid() == 0 && fchown(file.descriptor(), owner.st_uid, owner.st_gid) != 0) {
    return io::FileError("give away", file.path(), errno);
  }
  return absl::OkStatus();
}

absl::StatusOr<io::File> OpenPrivate(const std::string& path, int flags,
                                     const std::string& folder) {
  const int descriptor = open(path.c_str(), flags | O_CREAT | O_CLOEXEC, kOwnerAlone);
  if (descriptor < 0) return io::FileError("write", path, errno);
  io::File file(descriptor, path, io::DiskCalls::System());
  if (absl::Status status = KeepPrivate(file, folder); !status.ok()) return status;
  return file;
}

absl::Status Lock(const io::File& file) {
  while (flock(file.descriptor(), LOCK_EX) != 0) {
    if (errno != EINTR) return io::FileError("lock", file.path(), errno);
  }
  return absl::OkStatus();
}

}  // namespace

TokenFile::Version TokenFile::version() const {
  struct stat state = {};
  if (stat(path().c_str(), &state) != 0) return {};
  return {state.st_ino, state.st_ctim.tv_sec * 1'000'000'000 + state.st_ctim.tv_nsec,
          state.st_size};
}

absl::StatusOr<std::vector<StoredToken>> TokenFile::Read() const {
  const absl::StatusOr<std::string> text = io::ReadFile(path());
  if (absl::IsNotFound(text.status())) return std::vector<StoredToken>();
  if (!text.ok()) {
    return absl::FailedPreconditionError(absl::StrCat(
        "the tokens cannot be read, so every caller is refused: ", text.status().message()));
  }
  auto tokens = ParseTokens(*text);
  if (tokens.ok()) return tokens;
  return absl::FailedPreconditionError(
      absl::StrCat(path(), " is damaged (", tokens.status().message(),
                   "), so every caller is refused. Restore it from a copy, or remove it, which "
                   "invalidates every token, and make new ones with `isthmus token create --data ",
                   folder_, "` before the server is started"));
}

absl::Status TokenFile::Update(
    const std::function<absl::Status(std::vector<StoredToken>&)>& change) const {
  const absl::StatusOr<io::File> lock = OpenPrivate(path() + ".lock", O_RDWR, folder_);
  if (!lock.ok()) return lock.status();
  if (absl::Status status = Lock(*lock); !status.ok()) return status;
  auto tokens = Read();
  if (!tokens.ok()) return tokens.status();
  if (absl::Status status = change(*tokens); !status.ok()) return status;
  return Replace(PrintTokens(*tokens));
}

absl::Status TokenFile::Replace(const std::string& text) const {
  const std::string part = path() + ".part";
  absl::Cleanup remove = [&part] { std::remove(part.c_str()); };
  absl::StatusOr<io::File> file = OpenPrivate(part, O_WRONLY | O_TRUNC, folder_);
  if (!file.ok()) return file.status();
  absl::Status status = file->Write(text.data(), text.size(), 0);
  if (status.ok()) status = file->Sync();
  if (status.ok()) status = file->Close();
  if (!status.ok()) return status;
  if (rename(part.c_str(), path().c_str()) != 0) {
    return io::FileError("replace", path(), errno);
  }
  std::move(remove).Cancel();
  return io::SyncFolder(folder_);
}

}  // namespace isthmus::access
