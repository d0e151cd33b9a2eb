#include "core/io/file_io.h"

#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace isthmus::io {
namespace {

struct Meaning {
  absl::StatusCode code = absl::StatusCode::kUnavailable;
  const char* advice = "";
};

Meaning MeaningOf(int error) {
  using absl::StatusCode;
  switch (error) {
    case ENOENT:
    case ENOTDIR:
      return {StatusCode::kNotFound};
    case EACCES:
    case EPERM:
      return {StatusCode::kPermissionDenied, "; give this user the right to"};
    case EROFS:
      return {StatusCode::kPermissionDenied, "; make its disk writable"};
    case EISDIR:
      return {StatusCode::kFailedPrecondition};
    case ENOSPC:
    case EDQUOT:
      return {StatusCode::kResourceExhausted, "; make room on its disk"};
    case EFBIG:
      return {StatusCode::kResourceExhausted, "; raise the limit on the size of files"};
    case EMFILE:
    case ENFILE:
      return {StatusCode::kUnavailable, "; raise the limit on open files"};
    case EIO:
      return {StatusCode::kUnavailable, "; see whether its disk is well"};
    default:
      return {};
  }
}

// Calls some(done), which returns as read(2) does, until all is done or nothing more is. The bytes
// done, or -1 with errno.
template <typename Some>
ssize_t DoAll(size_t size, const Some& some) {
  size_t done = 0;
  while (done < size) {
    const ssize_t n = some(done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return -1;
    if (n == 0) break;
    done += static_cast<size_t>(n);
  }
  return static_cast<ssize_t>(done);
}

}  // namespace

std::string Explain(int error) { return absl::StrCat(strerror(error), MeaningOf(error).advice); }

absl::Status FileError(const std::string& action, const std::string& path, int error) {
  return {MeaningOf(error).code, absl::StrCat("cannot ", action, " ", path, ": ", Explain(error))};
}

DiskSpace SpaceOf(const std::string& folder) {
  struct statvfs disk = {};
  if (statvfs(folder.c_str(), &disk) != 0) return {};
  return {uint64_t{disk.f_bavail} * disk.f_frsize, uint64_t{disk.f_blocks} * disk.f_frsize};
}

const DiskCalls& DiskCalls::System() {
  static const DiskCalls calls{pwrite, pread, fdatasync, fsync, [](const std::string& folder) {
                                 struct statvfs disk = {};
                                 // If it does not tell, the write will.
                                 if (statvfs(folder.c_str(), &disk) != 0) return ~uint64_t{0};
                                 return uint64_t{disk.f_bavail} * disk.f_frsize;
                               }};
  return calls;
}

const DiskCalls& DiskCalls::Streams() {
  static const DiskCalls calls{
      [](int file, const void* data, size_t size, off_t) { return ::write(file, data, size); },
      [](int file, void* data, size_t size, off_t) { return ::read(file, data, size); },
      {},
      {},
      {}};
  return calls;
}

File::File(int descriptor, std::string path, const DiskCalls& disk)
    : descriptor_(descriptor), path_(std::move(path)), disk_(&disk) {}

absl::StatusOr<File> File::Open(const std::string& path, int flags, const DiskCalls& disk) {
  const int descriptor = open(path.c_str(), flags | O_CLOEXEC, 0666);
  if (descriptor < 0) return FileError("open", path, errno);
  return File(descriptor, path, disk);
}

File::~File() { (void)Close(); }

File::File(File&& other) noexcept { *this = std::move(other); }

File& File::operator=(File&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(path_, other.path_);
  std::swap(disk_, other.disk_);
  return *this;
}

absl::StatusOr<uint64_t> File::Size() const {
  struct stat info = {};
  if (fstat(descriptor_, &info) != 0) return FileError("read", path_, errno);
  return static_cast<uint64_t>(info.st_size);
}

absl::Status File::Write(const void* data, size_t size, uint64_t offset) const {
  const ssize_t done = DoAll(size, [&](size_t from) {
    return disk_->write(descriptor_, static_cast<const char*>(data) + from, size - from,
                        static_cast<off_t>(offset + from));
  });
  if (done == static_cast<ssize_t>(size)) return absl::OkStatus();
  return FileError("write", path_, done < 0 ? errno : ENOSPC);
}

absl::StatusOr<size_t> File::Read(void* data, size_t size, uint64_t offset) const {
  const ssize_t done = DoAll(size, [&](size_t from) {
    return disk_->read(descriptor_, static_cast<char*>(data) + from, size - from,
                       static_cast<off_t>(offset + from));
  });
  if (done < 0) return FileError("read", path_, errno);
  return static_cast<size_t>(done);
}

absl::Status File::Truncate(uint64_t size) const {
  if (ftruncate(descriptor_, static_cast<off_t>(size)) == 0) return absl::OkStatus();
  return FileError("shorten", path_, errno);
}

absl::Status File::Sync() const {
  return disk_->sync(descriptor_) == 0 ? absl::OkStatus() : FileError("sync", path_, errno);
}

absl::Status File::Close() {
  const int descriptor = std::exchange(descriptor_, -1);
  if (descriptor < 0 || close(descriptor) == 0) return absl::OkStatus();
  return FileError("write", path_, errno);
}

absl::StatusOr<std::string> ReadFile(const std::string& path) {
  const auto file = File::Open(path, O_RDONLY, DiskCalls::Streams());
  if (!file.ok()) return file.status();
  const absl::StatusOr<uint64_t> expected = file->Size();
  if (!expected.ok()) return expected.status();
  std::string bytes;
  // Until the end, not the size: pipes have none, and files may grow.
  for (size_t size = 0, more = *expected + 1;; more = 65536) {
    bytes.resize(size + more);
    const absl::StatusOr<size_t> got = file->Read(bytes.data() + size, more, size);
    if (!got.ok()) return got.status();
    size += *got;
    bytes.resize(size);
    if (*got < more) return bytes;
  }
}

absl::Status WriteFile(const std::string& path, const std::string& bytes) {
  absl::StatusOr<File> file = File::Open(path, O_WRONLY | O_CREAT | O_TRUNC, DiskCalls::Streams());
  if (!file.ok()) return file.status();
  absl::Status status = file->Write(bytes.data(), bytes.size(), 0);
  const absl::Status closed = file->Close();
  return status.ok() ? closed : status;
}

}  // namespace isthmus::io
