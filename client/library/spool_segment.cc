#include "client/library/spool_segment.h"

#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <utility>

#include "core/io/crc32c.h"

namespace isthmus::client {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are stored as they are");

constexpr char kMagic[] = "ISTHSPL1";
constexpr size_t kMagicBytes = 8, kFixedHeader = kMagicBytes + 4 + 4 + 8 + 8, kMaxOwner = 256;
constexpr uint32_t kMarker = 0x43535049;
constexpr size_t kSearchBytes = 1 << 16;

template <typename T>
void Put(std::string& out, T value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

template <typename T>
T Get(const char* from) {
  T value;
  std::memcpy(&value, from, sizeof(T));
  return value;
}

absl::Status Failure(const char* action, const std::string& path) {
  const int code = errno;
  const bool full = code == ENOSPC || code == EDQUOT || code == EFBIG;
  const std::string message = absl::StrCat("cannot ", action, " ", path, ": ", strerror(code));
  if (full) return absl::ResourceExhaustedError(message + "; make room on the disk of the spool");
  return absl::UnavailableError(message);
}

// As many bytes as there are.
size_t ReadAt(int file, char* into, size_t size, uint64_t offset) {
  size_t done = 0;
  while (done < size) {
    const ssize_t n = pread(file, into + done, size - done, static_cast<off_t>(offset + done));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    done += static_cast<size_t>(n);
  }
  return done;
}

std::string Encode(const SegmentHeader& header) {
  std::string out(kMagic, kMagicBytes);
  Put(out, SpoolSegment::kVersion);
  Put(out, static_cast<uint32_t>(header.owner.size()));
  Put(out, header.first_sequence);
  Put(out, header.stamp_before_ns);
  out += header.owner;
  Put(out, io::Crc32c(out.data(), out.size()));
  return out;
}

}  // namespace

const DiskCalls& DiskCalls::System() {
  static const DiskCalls calls{[](int file, const void* data, size_t size, off_t offset) {
                                 return pwrite(file, data, size, offset);
                               },
                               [](int file) { return fdatasync(file); }};
  return calls;
}

absl::StatusOr<std::shared_ptr<SpoolSegment>> SpoolSegment::Create(const std::string& path,
                                                                   const SegmentHeader& header,
                                                                   const DiskCalls& disk) {
  const int file = open(path.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (file < 0) return Failure("make", path);
  std::shared_ptr<SpoolSegment> segment(new SpoolSegment(path, file, disk));
  segment->header_ = header;
  const std::string bytes = Encode(header);
  absl::Status status = segment->WriteAll(bytes, 0);
  if (status.ok()) status = segment->Sync();
  if (!status.ok()) {
    unlink(path.c_str());
    return status;
  }
  segment->header_bytes_ = segment->bytes_ = bytes.size();
  return segment;
}

absl::StatusOr<std::shared_ptr<SpoolSegment>> SpoolSegment::Open(const std::string& path,
                                                                 const SegmentHeader& expected,
                                                                 const DiskCalls& disk) {
  const int file = open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (file < 0) return Failure("open", path);
  std::shared_ptr<SpoolSegment> segment(new SpoolSegment(path, file, disk));
  absl::Status header = segment->ReadHeader();
  if (absl::IsDataLoss(header)) {
    segment->header_ = expected;
  } else if (!header.ok()) {
    return header;
  }
  const absl::StatusOr<uint64_t> size = segment->FileBytes();
  if (!size.ok()) return size.status();
  segment->bytes_ = *size;
  return segment;
}

SpoolSegment::~SpoolSegment() { close(file_); }

absl::Status SpoolSegment::ReadHeader() {
  std::string bytes(kFixedHeader + kMaxOwner + 4, '\0');
  bytes.resize(ReadAt(file_, bytes.data(), bytes.size(), 0));
  const absl::Status damaged =
      absl::DataLossError(absl::StrCat(path_, " does not begin like a file of a spool"));
  if (bytes.size() < kFixedHeader || bytes.compare(0, kMagicBytes, kMagic) != 0) return damaged;
  if (const auto version = Get<uint32_t>(&bytes[kMagicBytes]); version > kVersion) {
    return absl::FailedPreconditionError(absl::StrCat(
        path_, " has format ", version, ", written by a newer program; this one knows ", kVersion,
        ": use the newer one"));
  }
  const size_t owner = Get<uint32_t>(&bytes[kMagicBytes + 4]);
  const size_t end = kFixedHeader + owner;
  if (owner > kMaxOwner || bytes.size() < end + 4) return damaged;
  if (io::Crc32c(bytes.data(), end) != Get<uint32_t>(&bytes[end])) return damaged;
  header_.first_sequence = Get<uint64_t>(&bytes[kMagicBytes + 8]);
  header_.stamp_before_ns = Get<int64_t>(&bytes[kMagicBytes + 16]);
  header_.owner = bytes.substr(kFixedHeader, owner);
  header_bytes_ = end + 4;
  return absl::OkStatus();
}

absl::StatusOr<uint64_t> SpoolSegment::FileBytes() const {
  struct stat info = {};
  if (fstat(file_, &info) != 0) return Failure("read", path_);
  return static_cast<uint64_t>(info.st_size);
}

bool SpoolSegment::RecordAt(uint64_t offset, uint64_t size, bool verify, SpooledScan* scan) const {
  char head[kRecordHeaderBytes];
  if (offset + sizeof(head) > size) return false;
  if (ReadAt(file_, head, sizeof(head), offset) != sizeof(head)) return false;
  if (Get<uint32_t>(head) != kMarker) return false;
  if (io::Crc32c(head, 28) != Get<uint32_t>(head + 28)) return false;
  *scan = {Get<uint64_t>(head + 8), Get<int64_t>(head + 16), offset + sizeof(head),
           Get<uint32_t>(head + 4), Get<uint32_t>(head + 24)};
  if (scan->offset + scan->size > size) return false;
  return !verify || Read(*scan).ok();
}

uint64_t SpoolSegment::NextRecord(uint64_t from, uint64_t size, bool verify) const {
  char marker[4];
  std::memcpy(marker, &kMarker, 4);
  std::string piece(kSearchBytes, '\0');
  SpooledScan ignored;
  // Pieces overlap, so that a marker across their border is seen.
  for (uint64_t start = from; start + kRecordHeaderBytes <= size; start += kSearchBytes - 3) {
    const size_t read = ReadAt(file_, piece.data(), piece.size(), start);
    auto at = piece.begin();
    const auto end = piece.begin() + static_cast<std::ptrdiff_t>(read);
    while ((at = std::search(at, end, marker, marker + 4)) != end) {
      const uint64_t offset = start + static_cast<uint64_t>(at - piece.begin());
      if (RecordAt(offset, size, verify, &ignored)) return offset;
      ++at;
    }
  }
  return size;
}

absl::StatusOr<SpoolSegment::Contents> SpoolSegment::Find(bool verify) const {
  const absl::StatusOr<uint64_t> size = FileBytes();
  if (!size.ok()) return size.status();
  Contents contents;
  contents.end = header_bytes_;
  uint64_t lowest = header_.first_sequence;
  uint64_t offset = header_bytes_;
  while (offset < *size) {
    SpooledScan scan;
    if (!RecordAt(offset, *size, verify, &scan) || scan.sequence < lowest) {
      offset = NextRecord(offset + 1, *size, verify);
      continue;
    }
    contents.skipped += offset - contents.end;
    contents.scans.push_back(scan);
    contents.end = offset = scan.offset + scan.size;
    lowest = scan.sequence + 1;
  }
  return contents;
}

absl::StatusOr<SpooledScan> SpoolSegment::Append(uint64_t sequence, int64_t end_stamp_ns,
                                                 const std::string& payload) {
  SpooledScan scan{sequence, end_stamp_ns, bytes_ + kRecordHeaderBytes,
                   static_cast<uint32_t>(payload.size()),
                   io::Crc32c(payload.data(), payload.size())};
  std::string record;
  record.reserve(kRecordHeaderBytes + payload.size());
  Put(record, kMarker);
  Put(record, scan.size);
  Put(record, sequence);
  Put(record, end_stamp_ns);
  Put(record, scan.crc32c);
  Put(record, io::Crc32c(record.data(), record.size()));
  record += payload;
  if (absl::Status status = WriteAll(record, bytes_); !status.ok()) {
    (void)Truncate(bytes_);  // Else cut off when the spool is opened again.
    return status;
  }
  bytes_ += record.size();
  return scan;
}

absl::Status SpoolSegment::WriteAll(const std::string& bytes, uint64_t offset) {
  size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t n = disk_.write(file_, bytes.data() + done, bytes.size() - done,
                                  static_cast<off_t>(offset + done));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return Failure("write to", path_);
    done += static_cast<size_t>(n);
  }
  return absl::OkStatus();
}

absl::Status SpoolSegment::Sync() {
  return disk_.sync(file_) == 0 ? absl::OkStatus() : Failure("write to", path_);
}

absl::Status SpoolSegment::Truncate(uint64_t bytes) {
  if (ftruncate(file_, static_cast<off_t>(bytes)) != 0) return Failure("cut", path_);
  bytes_ = bytes;
  return absl::OkStatus();
}

absl::StatusOr<std::string> SpoolSegment::Read(const SpooledScan& scan) const {
  std::string payload(scan.size, '\0');
  const bool whole = ReadAt(file_, payload.data(), payload.size(), scan.offset) == payload.size();
  if (whole && io::Crc32c(payload.data(), payload.size()) == scan.crc32c) return payload;
  return absl::DataLossError(
      absl::StrCat("scan ", scan.sequence, " in ", path_, " is damaged: its checksum is wrong"));
}

absl::Status SyncFolder(const std::string& folder) {
  const int file = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file < 0) return Failure("open", folder);
  const int result = fsync(file);
  close(file);
  return result == 0 ? absl::OkStatus() : Failure("write to", folder);
}

}  // namespace isthmus::client
