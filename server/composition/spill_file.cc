#include "server/composition/spill_file.h"

#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <utility>

namespace isthmus::composition {
namespace {

// -1 and errno when there can be none.
int OpenUnnamed(const std::string& folder) {
  const int file = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (file >= 0 || (errno != EOPNOTSUPP && errno != EISDIR && errno != ENOENT)) return file;
  // A file system that has no unnamed files.
  std::string name = folder + "/spill-XXXXXX";
  const int named = ::mkostemp(name.data(), O_CLOEXEC);
  if (named >= 0) ::unlink(name.c_str());
  return named;
}

absl::Status WriteFailed(const std::string& folder, int error) {
  const std::string message = absl::StrCat("cannot keep parts of the map in a file in ", folder,
                                           ": ", std::strerror(error), "; ");
  if (error == ENOSPC || error == EDQUOT || error == EFBIG) {
    return absl::ResourceExhaustedError(
        absl::StrCat(message, "make room on its disk or give the server more memory (cache_mb)"));
  }
  return absl::UnavailableError(absl::StrCat(message, "see whether its disk is well"));
}

}  // namespace

SpillFile::SpillFile(std::string folder, uint64_t reserve_bytes)
    : folder_(std::move(folder)), reserve_bytes_(reserve_bytes) {}

SpillFile::~SpillFile() {
  if (file_ >= 0) ::close(file_);
}

ssize_t SpillFile::WriteSome(int file, const char* data, size_t size, uint64_t offset) {
  return ::pwrite(file, data, size, static_cast<off_t>(offset));
}

ssize_t SpillFile::ReadSome(int file, char* data, size_t size, uint64_t offset) const {
  return ::pread(file, data, size, static_cast<off_t>(offset));
}

uint64_t SpillFile::FreeDiskBytes() const {
  struct statvfs disk = {};
  // If it does not tell, the write will.
  if (::statvfs(folder_.c_str(), &disk) != 0) return ~uint64_t{0};
  return uint64_t{disk.f_bavail} * disk.f_frsize;
}

absl::StatusOr<Extent> SpillFile::Allocate(size_t size) {
  MutexLock lock(&mutex_);
  if (file_ < 0) file_ = OpenUnnamed(folder_);
  if (file_ < 0) return WriteFailed(folder_, errno);
  const Extent extent = extents_.Allocate(size);
  if (extents_.end() > length_) {
    const uint64_t free = FreeDiskBytes(), more = extents_.end() - length_;
    if (free < more || free - more < reserve_bytes_) {
      extents_.Free(extent);
      return WriteFailed(folder_, ENOSPC);
    }
    length_ = extents_.end();
  }
  return extent;
}

absl::Status SpillFile::WriteAll(const Extent& extent, const char* data, size_t size) {
  for (size_t done = 0; done < size;) {
    const ssize_t some = WriteSome(file_, data + done, size - done, extent.offset + done);
    if (some < 0 && errno == EINTR) continue;
    if (some <= 0) return WriteFailed(folder_, some < 0 ? errno : ENOSPC);
    done += static_cast<size_t>(some);
  }
  return absl::OkStatus();
}

absl::StatusOr<Extent> SpillFile::Write(const void* data, size_t size) {
  absl::StatusOr<Extent> extent = Allocate(size);
  if (!extent.ok()) return extent;
  const absl::Status status = WriteAll(*extent, static_cast<const char*>(data), size);
  if (status.ok()) return extent;
  Free(*extent);
  return status;
}

absl::Status SpillFile::Read(const Extent& extent, uint64_t from, void* data, size_t size) const {
  char* out = static_cast<char*>(data);
  for (size_t done = 0; done < size;) {
    const ssize_t some = ReadSome(file_, out + done, size - done, extent.offset + from + done);
    if (some < 0 && errno == EINTR) continue;
    if (some <= 0) {
      return absl::DataLossError(
          absl::StrCat("cannot read back parts of the map from a file in ", folder_, ": ",
                       some < 0 ? std::strerror(errno) : "it ends too early",
                       "; see whether its disk is well, then restart the server"));
    }
    done += static_cast<size_t>(some);
  }
  return absl::OkStatus();
}

void SpillFile::Free(const Extent& extent) {
  MutexLock lock(&mutex_);
  extents_.Free(extent);
  // So that the disk has it again. A file that stays long does no harm but take room.
  if (extents_.end() < length_ && ::ftruncate(file_, static_cast<off_t>(extents_.end())) == 0) {
    length_ = extents_.end();
  }
}

uint64_t SpillFile::bytes_in_use() const {
  MutexLock lock(&mutex_);
  return extents_.in_use();
}

}  // namespace isthmus::composition
