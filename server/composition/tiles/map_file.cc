#include "server/composition/tiles/map_file.h"

#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
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

absl::StatusOr<io::File> MapFile::OpenOwn(const char* name, int flags) const {
  constexpr char kWayOut[] =
      ". Mend that, or remove it while no server runs: the map is composed anew till then";
  const std::string path = PathOf(name);
  io::File file(::open(path.c_str(), flags | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0600),
                NameIn(folder_), disk_);
  if (!file.is_open() && errno == ENOENT) return absl::NotFoundError(path + " is not there");
  if (!file.is_open() && errno == ELOOP) {
    return absl::FailedPreconditionError(absl::StrCat(path, " is a link", kWayOut));
  }
  if (!file.is_open()) {
    const absl::Status why = io::FileError("open", path, errno);
    return absl::FailedPreconditionError(absl::StrCat(why.message(), kWayOut));
  }
  struct stat about = {};
  if (::fstat(file.descriptor(), &about) == 0 && S_ISREG(about.st_mode)) return file;
  return absl::FailedPreconditionError(absl::StrCat(path, " is not a file", kWayOut));
}

absl::StatusOr<io::File> MapFile::OpenPoints(int flags) const {
  absl::StatusOr<io::File> file = OpenOwn(kPointsName, flags);
  // Held while the process lives.
  if (!file.ok() || ::flock(file->descriptor(), LOCK_EX | LOCK_NB) == 0) return file;
  return absl::FailedPreconditionError(absl::StrCat("another process has ", PathOf(kPointsName),
                                                    ": give each server a folder of its own"));
}

absl::StatusOr<std::string> MapFile::ReadIndex() const {
  const absl::StatusOr<io::File> file = OpenOwn(kIndexName, O_RDONLY);
  if (!file.ok()) return file.status();
  const absl::StatusOr<uint64_t> size = file->Size();
  if (!size.ok()) return size.status();
  std::string bytes(*size, '\0');
  const absl::StatusOr<size_t> read = file->Read(bytes.data(), bytes.size(), 0);
  if (!read.ok()) return read.status();
  bytes.resize(*read);
  return bytes;
}

absl::Status MapFile::Open() {
  if (file_.is_open()) return absl::OkStatus();
  if (kept_.ok()) {
    absl::StatusOr<io::File> named = OpenPoints(O_RDWR | O_CREAT);
    kept_ = named.status();
    if (kept_.ok()) {
      ::unlink(PathOf(kIndexName).c_str());  // It says what lay there before.
      if (absl::Status status = named->Truncate(0); !status.ok()) return status;
      file_ = *std::move(named);
      is_named_ = true;
      return absl::OkStatus();
    }
  }
  file_ = io::File(OpenUnnamed(folder_), NameIn(folder_), disk_);
  return file_.is_open() ? absl::OkStatus() : io::FileError("keep", NameIn(folder_), errno);
}

std::string MapFile::TakeSaved(uint64_t made_with) {
  MutexLock lock(&mutex_);
  std::string state;
  if (file_.is_open()) return state;
  absl::StatusOr<io::File> points = OpenPoints(O_RDWR);
  const absl::StatusOr<std::string> index = ReadIndex();
  for (const absl::Status& status : {points.status(), index.status()}) {
    if (absl::IsFailedPrecondition(status)) kept_ = status;
  }
  if (!points.ok() || !index.ok()) return state;
  file_ = *std::move(points);
  if (TakeIndex(made_with, *index, &state)) {
    is_named_ = true;
    return state;
  }
  file_ = io::File();
  return {};
}

absl::Status MapFile::kept() const {
  MutexLock lock(&mutex_);
  return kept_;
}

bool MapFile::TakeIndex(uint64_t made_with, const std::string& index, std::string* state) {
  const absl::StatusOr<uint64_t> length = file_.Size();
  if (!length.ok()) return false;
  absl::StatusOr<StateReader> reader = OpenState(kMagic, kVersion, made_with, index, "the map");
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
    if (!is_named_) return kept_;
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
  return absl::DataLossError(read.ok()
                                 ? absl::StrCat("cannot read ", NameIn(folder_), ": it ends early")
                                 : std::string(read.status().message()));
}

absl::Status MapFile::Verify(const Extent& extent) const {
  Piece piece;
  {
    MutexLock lock(&mutex_);
    if (!unverified_.contains(extent.offset)) return absl::OkStatus();
    piece = pieces_.at(extent.offset);
  }
  std::vector<char> bytes(piece.size);
  const absl::Status status = ReadBytes(extent.offset, bytes.data(), bytes.size());
  if (!status.ok()) return status;
  if (ChecksumOf(bytes.data(), bytes.size()) != piece.checksum) {
    return absl::DataLossError(PathOf(kPointsName) + " is damaged");
  }
  MutexLock lock(&mutex_);
  unverified_.erase(extent.offset);
  return absl::OkStatus();
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
