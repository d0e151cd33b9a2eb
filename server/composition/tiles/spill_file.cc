#include "server/composition/tiles/spill_file.h"

#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
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

// The file's name in errors.
std::string NameIn(const std::string& folder) { return "parts of the map in a file in " + folder; }

absl::Status WithAdvice(const absl::Status& status) {
  if (!absl::IsResourceExhausted(status)) return absl::UnavailableError(status.message());
  return {status.code(),
          absl::StrCat(status.message(), " or give the server more memory (cache_mb)")};
}

}  // namespace

SpillFile::SpillFile(std::string folder, uint64_t reserve_bytes, const io::DiskCalls& disk)
    : folder_(std::move(folder)), reserve_bytes_(reserve_bytes), disk_(disk) {}

absl::StatusOr<Extent> SpillFile::Allocate(size_t size) {
  MutexLock lock(&mutex_);
  if (!file_.is_open()) file_ = io::File(OpenUnnamed(folder_), NameIn(folder_), disk_);
  if (!file_.is_open()) return io::FileError("keep", NameIn(folder_), errno);
  const Extent extent = extents_.Allocate(size);
  if (extents_.end() > length_) {
    const uint64_t free = disk_.free_bytes(folder_), more = extents_.end() - length_;
    if (free < more || free - more < reserve_bytes_) {
      extents_.Free(extent);
      return io::FileError("keep", NameIn(folder_), ENOSPC);
    }
    length_ = extents_.end();
  }
  return extent;
}

absl::StatusOr<Extent> SpillFile::Write(const void* data, size_t size) {
  absl::StatusOr<Extent> extent = Allocate(size);
  if (!extent.ok()) return WithAdvice(extent.status());
  const absl::Status status = file_.Write(data, size, extent->offset);
  if (status.ok()) return extent;
  Free(*extent);
  return WithAdvice(status);
}

absl::Status SpillFile::Read(const Extent& extent, uint64_t from, void* data, size_t size) const {
  const absl::StatusOr<size_t> read = file_.Read(data, size, extent.offset + from);
  if (read.ok() && *read == size) return absl::OkStatus();
  return absl::DataLossError(
      absl::StrCat(read.ok() ? absl::StrCat("cannot read ", NameIn(folder_), ": it ends too early")
                             : read.status().message(),
                   "; restart the server"));
}

void SpillFile::Free(const Extent& extent) {
  MutexLock lock(&mutex_);
  extents_.Free(extent);
  // So that the disk has it again. A file that stays long does no harm but take room.
  if (extents_.end() < length_ && file_.Truncate(extents_.end()).ok()) length_ = extents_.end();
}

uint64_t SpillFile::bytes_in_use() const {
  MutexLock lock(&mutex_);
  return extents_.in_use();
}

}  // namespace isthmus::composition
