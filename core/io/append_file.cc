#include "core/io/append_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "core/io/file_io.h"

namespace isthmus::io {

absl::Status SyncFolder(const std::string& path, SyncCall sync) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return FileError("open", path, errno);
  const bool is_synced = sync(descriptor) == 0;
  const absl::Status status = is_synced ? absl::OkStatus() : FileError("sync", path, errno);
  close(descriptor);
  return status;
}

absl::StatusOr<std::unique_ptr<AppendFile>> AppendFile::Open(const std::string& path) {
  return Open(path, O_RDWR | O_CREAT);
}

absl::StatusOr<std::unique_ptr<AppendFile>> AppendFile::OpenToRead(const std::string& path) {
  return Open(path, O_RDONLY);
}

absl::StatusOr<std::unique_ptr<AppendFile>> AppendFile::Open(const std::string& path, int flags) {
  const int descriptor = open(path.c_str(), flags | O_CLOEXEC, 0666);
  if (descriptor < 0) return FileError("open", path, errno);
  struct stat info;
  if (fstat(descriptor, &info) != 0) {
    const int error = errno;
    close(descriptor);
    return FileError("open", path, error);
  }
  return std::unique_ptr<AppendFile>(
      new AppendFile(path, descriptor, static_cast<uint64_t>(info.st_size)));
}

// The contents of a file that is opened survived so far, but might not survive a power cut now.
AppendFile::AppendFile(std::string path, int descriptor, uint64_t size)
    : path_(std::move(path)), descriptor_(descriptor), size_(size), synced_size_(0) {}

AppendFile::~AppendFile() { close(descriptor_); }

absl::Status AppendFile::Append(const std::string& bytes) {
  size_t written = 0;
  while (written < bytes.size()) {
    const ssize_t put = pwrite(descriptor_, bytes.data() + written, bytes.size() - written,
                               static_cast<off_t>(size_ + written));
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) {
      const absl::Status status = FileError("write", path_, errno);
      is_broken_ = written > 0 && !Truncate(size_).ok();
      return status;
    }
    written += static_cast<size_t>(put);
  }
  size_ += bytes.size();
  return absl::OkStatus();
}

absl::Status AppendFile::Truncate(uint64_t size) {
  if (ftruncate(descriptor_, static_cast<off_t>(size)) != 0) {
    return FileError("shorten", path_, errno);
  }
  size_ = size;
  if (size < synced_size_) synced_size_ = size;
  return absl::OkStatus();
}

absl::Status AppendFile::Sync(SyncCall sync) {
  if (sync(descriptor_) != 0) {
    is_suspect_ = true;
    return FileError("sync", path_, errno);
  }
  synced_size_ = size_;
  return absl::OkStatus();
}

absl::StatusOr<std::string> AppendFile::Read(uint64_t offset, size_t size) const {
  std::string bytes(size, '\0');
  size_t got = 0;
  while (got < size) {
    const ssize_t more =
        pread(descriptor_, bytes.data() + got, size - got, static_cast<off_t>(offset + got));
    if (more < 0 && errno == EINTR) continue;
    if (more < 0) return FileError("read", path_, errno);
    if (more == 0) break;
    got += static_cast<size_t>(more);
  }
  bytes.resize(got);
  return bytes;
}

}  // namespace isthmus::io
