#include "server/composition/tiles/map_file.h"

#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <utility>

#include "core/io/part_file.h"
#include "core/state_codec.h"

namespace isthmus::composition {
namespace {

constexpr char kPointsName[] = "composed.points", kIndexName[] = "composed.index";  // Layout.
constexpr char kMagic[] = "IMAP";                                                   // Format.
constexpr uint32_t kVersion = 2;                                                    // Format.

// A piece as the index names it.
struct Named {
  Extent extent;
  uint64_t size = 0, checksum = 0;
};
void Fields(IsRecord<Named> auto& self, auto& io) { io(self.extent, self.size, self.checksum); }

// -1 and errno when there can be none.
int OpenUnnamed(const std::string& folder) {
  const int file = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (file >= 0 || (errno != EOPNOTSUPP && errno != EISDIR && errno != ENOENT)) return file;
  // A file system that has no unnamed files.
  std::string name = folder + "/composed-XXXXXX";
  const int named = ::mkostemp(name.data(), O_CLOEXEC);
  if (named >= 0) ::unlink(name.c_str());
  return named;
}

// The file's name in errors.
std::string NameIn(const std::string& folder) { return "parts of the map in a file in " + folder; }

absl::Status FullOrAway(const absl::Status& status) {
  return absl::IsResourceExhausted(status) ? status : absl::UnavailableError(status.message());
}

uint64_t ChecksumOf(const void* data, size_t size) {
  return StateChecksum(static_cast<const char*>(data), size);
}

}  // namespace

MapFile::MapFile(std::string folder, uint64_t reserve_bytes, const io::DiskCalls& disk)
    : folder_(std::move(folder)), reserve_bytes_(reserve_bytes), disk_(disk) {}

io::File MapFile::OpenNamed() const {
  const std::string path = PathOf(kPointsName);
  io::File file(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600),
                NameIn(folder_), disk_);
  // Held while the process lives.
  if (file.is_open() && ::flock(file.descriptor(), LOCK_EX | LOCK_NB) != 0) file = io::File();
  return file;
}

absl::Status MapFile::Open() {
  if (file_.is_open()) return absl::OkStatus();
  if (io::File named = OpenNamed(); named.is_open()) {
    ::unlink(PathOf(kIndexName).c_str());  // It says what lay there before.
    if (absl::Status status = named.Truncate(0); !status.ok()) return status;
    file_ = std::move(named);
    is_named_ = true;
    return absl::OkStatus();
  }
  file_ = io::File(OpenUnnamed(folder_), NameIn(folder_), disk_);
  return file_.is_open() ? absl::OkStatus() : io::FileError("keep", NameIn(folder_), errno);
}

std::string MapFile::TakeSaved(uint64_t made_with) {
  MutexLock lock(&mutex_);
  std::string state;
  if (file_.is_open() || ::access(PathOf(kIndexName).c_str(), F_OK) != 0) return state;
  file_ = OpenNamed();
  if (!file_.is_open()) return state;
  if (TakeIndex(made_with, &state)) {
    is_named_ = true;
    return state;
  }
  file_ = io::File();
  return {};
}

bool MapFile::TakeIndex(uint64_t made_with, std::string* state) {
  const absl::StatusOr<std::string> bytes = io::ReadFile(PathOf(kIndexName));
  const absl::StatusOr<uint64_t> length = file_.Size();
  if (!bytes.ok() || !length.ok()) return false;
  absl::StatusOr<StateReader> reader = OpenState(kMagic, kVersion, made_with, *bytes, "the map");
  if (!reader.ok()) return false;
  std::vector<Named> named;
  (*reader)(named, *state);
  if (!reader->ok() || reader->remaining() > 0) return false;
  std::vector<Extent> extents;
  for (const Named& piece : named) {
    if (piece.size > piece.extent.size || piece.extent.offset + piece.size > *length) return false;
    extents.push_back(piece.extent);
  }
  auto allocator = ExtentAllocator::Of(std::move(extents));
  if (!allocator) return false;
  extents_ = *std::move(allocator);
  length_ = std::max(*length, extents_.end());
  for (const Named& piece : named) {
    pieces_[piece.extent.offset] = {piece.size, piece.checksum};
    saved_.insert(piece.extent.offset);
  }
  unverified_ = saved_;
  return true;
}

std::string MapFile::IndexOf(uint64_t made_with, const std::string& state,
                             const std::vector<Extent>& extents) const {
  std::vector<Named> named;
  named.reserve(extents.size());
  {
    MutexLock lock(&mutex_);
    for (const Extent& extent : extents) {
      const Piece& piece = pieces_.at(extent.offset);
      named.push_back({extent, piece.size, piece.checksum});
    }
  }
  StateWriter writer;
  writer(named, state);
  return SealState(kMagic, kVersion, made_with, writer.Take());
}

absl::Status MapFile::Save(uint64_t made_with, const std::string& state,
                           const std::vector<Extent>& extents) {
  {
    MutexLock lock(&mutex_);
    if (absl::Status status = Open(); !status.ok()) return FullOrAway(status);
    if (!is_named_ || is_damaged_) return absl::OkStatus();
    // From now on either index may be the one that is found.
    for (const Extent& extent : extents) saved_.insert(extent.offset);
  }
  absl::Status status = file_.Sync();
  if (status.ok()) {
    status = io::ReplaceFile(PathOf(kIndexName), IndexOf(made_with, state, extents));
  }
  if (!status.ok()) return FullOrAway(status);
  MutexLock lock(&mutex_);
  saved_.clear();
  for (const Extent& extent : extents) saved_.insert(extent.offset);
  for (const Extent& extent : std::exchange(held_, {})) GiveBack(extent);
  return absl::OkStatus();
}

absl::StatusOr<Extent> MapFile::Allocate(size_t size) {
  MutexLock lock(&mutex_);
  if (absl::Status status = Open(); !status.ok()) return status;
  const Extent extent = extents_.Allocate(size);
  // The disk has the room of free pieces, too.
  const uint64_t free = disk_.free_bytes(folder_);
  if (free < extent.size || free - extent.size < reserve_bytes_) {
    extents_.Free(extent);
    return io::FileError("keep", NameIn(folder_), ENOSPC);
  }
  length_ = std::max(length_, extents_.end());
  return extent;
}

absl::StatusOr<Extent> MapFile::Write(const void* data, size_t size) {
  absl::StatusOr<Extent> extent = Allocate(size);
  if (!extent.ok()) return FullOrAway(extent.status());
  const absl::Status status = file_.Write(data, size, extent->offset);
  const uint64_t checksum = ChecksumOf(data, size);
  MutexLock lock(&mutex_);
  if (!status.ok()) {
    GiveBack(*extent);
    return FullOrAway(status);
  }
  pieces_[extent->offset] = {size, checksum};
  return extent;
}

absl::Status MapFile::ReadBytes(uint64_t offset, void* data, size_t size) const {
  const absl::StatusOr<size_t> read = file_.Read(data, size, offset);
  if (read.ok() && *read == size) return absl::OkStatus();
  return absl::DataLossError(
      absl::StrCat(read.ok() ? absl::StrCat("cannot read ", NameIn(folder_), ": it ends too early")
                             : read.status().message(),
                   "; restart the server"));
}

// The next start finds nothing in a damaged file.
absl::Status MapFile::Verify(const Extent& extent) const {
  Piece piece;
  {
    MutexLock lock(&mutex_);
    if (!unverified_.contains(extent.offset)) return absl::OkStatus();
    piece = pieces_.at(extent.offset);
  }
  std::vector<char> bytes(piece.size);
  absl::Status status = ReadBytes(extent.offset, bytes.data(), bytes.size());
  if (status.ok() && ChecksumOf(bytes.data(), bytes.size()) != piece.checksum) {
    status = absl::DataLossError(
        absl::StrCat(PathOf(kPointsName), " is damaged; restart the server, which composes the ",
                     "map from what is stored"));
  }
  MutexLock lock(&mutex_);
  if (status.ok()) {
    unverified_.erase(extent.offset);
  } else if (!std::exchange(is_damaged_, true)) {
    ::unlink(PathOf(kIndexName).c_str());
  }
  return status;
}

absl::Status MapFile::Read(const Extent& extent, uint64_t from, void* data, size_t size) const {
  if (absl::Status status = Verify(extent); !status.ok()) return status;
  return ReadBytes(extent.offset + from, data, size);
}

void MapFile::GiveBack(const Extent& extent) {
  extents_.Free(extent);
  // The disk has it again, and points of deleted sessions are gone.
  if (extents_.end() < length_ && file_.Truncate(extents_.end()).ok()) length_ = extents_.end();
  if (extent.offset >= length_) return;
  // A file system that cannot do this keeps the room until it is written over.
  (void)::fallocate(file_.descriptor(), FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE,
                    static_cast<off_t>(extent.offset), static_cast<off_t>(extent.size));
}

void MapFile::Free(const Extent& extent) {
  MutexLock lock(&mutex_);
  pieces_.erase(extent.offset);
  unverified_.erase(extent.offset);
  if (saved_.contains(extent.offset)) {
    held_.push_back(extent);
  } else {
    GiveBack(extent);
  }
}

uint64_t MapFile::bytes_in_use() const {
  MutexLock lock(&mutex_);
  return extents_.in_use();
}

}  // namespace isthmus::composition
