#include "client/library/spool/spool_segment.h"

#include <absl/strings/str_cat.h>
#include <unistd.h>

#include <vector>

#include "core/byte_stream.h"
#include "core/io/crc32c.h"

namespace isthmus::client {
namespace {

constexpr char kMagic[] = "ISTHSPL1";
constexpr char kMarker[] = "IPSC";
constexpr size_t kMagicBytes = 8, kFixedHeader = kMagicBytes + 4 + 4 + 8 + 8, kMaxOwner = 256;

std::string Encode(const SegmentHeader& header) {
  std::string out(kMagic, kMagicBytes);
  AppendBytes(SpoolSegment::kVersion, out);
  AppendBytes(static_cast<uint32_t>(header.owner.size()), out);
  AppendBytes(header.first_sequence, out);
  AppendBytes(header.stamp_before_ns, out);
  out += header.owner;
  AppendBytes(io::Crc32c(out.data(), out.size()), out);
  return out;
}

}  // namespace

absl::StatusOr<std::shared_ptr<SpoolSegment>> SpoolSegment::Create(const std::string& path,
                                                                   const SegmentHeader& header,
                                                                   const io::DiskCalls& disk) {
  auto file = io::AppendFile::Open(path, disk);
  if (!file.ok()) return file.status();
  std::shared_ptr<SpoolSegment> segment(new SpoolSegment(*std::move(file)));
  segment->header_ = header;
  absl::Status status = segment->Truncate(0);
  if (status.ok()) status = segment->file_->Append(Encode(header));
  if (status.ok()) status = segment->Sync();
  if (!status.ok()) {
    unlink(path.c_str());
    return status;
  }
  segment->header_bytes_ = segment->bytes();
  return segment;
}

absl::StatusOr<std::shared_ptr<SpoolSegment>> SpoolSegment::Open(const std::string& path,
                                                                 const SegmentHeader& expected,
                                                                 const io::DiskCalls& disk) {
  auto file = io::AppendFile::Open(path, disk);
  if (!file.ok()) return file.status();
  std::shared_ptr<SpoolSegment> segment(new SpoolSegment(*std::move(file)));
  const absl::Status header = segment->ReadHeader();
  if (absl::IsDataLoss(header)) {
    segment->header_ = expected;
  } else if (!header.ok()) {
    return header;
  }
  return segment;
}

absl::Status SpoolSegment::ReadHeader() {
  const absl::StatusOr<std::string> bytes = file_->Read(0, kFixedHeader + kMaxOwner + 4);
  if (!bytes.ok()) return bytes.status();
  const absl::Status damaged =
      absl::DataLossError(absl::StrCat(path(), " does not begin like a file of a spool"));
  ByteReader reader(*bytes);
  if (reader.ReadString(kMagicBytes) != kMagic) return damaged;
  const auto version = reader.Read<uint32_t>();
  const size_t owner = reader.Read<uint32_t>();
  header_.first_sequence = reader.Read<uint64_t>();
  header_.stamp_before_ns = reader.Read<int64_t>();
  header_.owner = reader.ReadString(owner);
  const uint32_t checksum = reader.Read<uint32_t>();
  if (!reader.ok() || io::Crc32c(bytes->data(), kFixedHeader + owner) != checksum) return damaged;
  // Only now: a byte that was flipped is no other program. Headers of all versions begin alike.
  if (version > kVersion) {
    return absl::FailedPreconditionError(absl::StrCat(
        path(), " has format ", version, ", written by a newer program; this one knows ", kVersion,
        ": use the newer one"));
  }
  header_bytes_ = kFixedHeader + owner + sizeof(checksum);
  return absl::OkStatus();
}

absl::StatusOr<io::RecordIndex> SpoolSegment::Find(io::Look look) const {
  auto index = io::FindRecords(*file_, kMarker, header_bytes_, look);
  if (!index.ok()) return index;
  uint64_t lowest = header_.first_sequence;
  std::erase_if(index->records, [&](const io::Record& scan) {
    if (scan.sequence >= lowest) {
      lowest = scan.sequence + 1;
      return false;
    }
    index->damaged.push_back({scan.begin(), scan.end() - scan.begin()});
    return true;
  });
  return index;
}

absl::StatusOr<io::Record> SpoolSegment::Append(uint64_t sequence, int64_t end_stamp_ns,
                                                const std::string& payload) {
  // Bytes left by an error are overwritten, or cut off when the spool is opened again.
  return io::AppendRecord(*file_, kMarker, sequence, end_stamp_ns, payload);
}

}  // namespace isthmus::client
