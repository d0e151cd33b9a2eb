#include "storage/archive/scan_segment.h"

#include <absl/strings/match.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <system_error>

#include "core/io/crc32c.h"
#include "storage/records/byte_stream.h"

namespace isthmus::storage {
namespace {

constexpr char kSegmentMagic[] = "ISTHSCAN";
constexpr size_t kSegmentMagicSize = 8;
constexpr uint32_t kVersion = 1;
constexpr char kSuffix[] = ".scans";
constexpr size_t kSearchBytes = 1 << 20;  // Read at a time while a record is looked for.

std::string HeadOfVersion(uint32_t version) {
  std::string head(kSegmentMagic, kSegmentMagicSize);
  AppendBytes(version, head);
  AppendBytes(io::Crc32c(head.data(), head.size()), head);
  return head;
}

// A damaged head says nothing: its records may still be whole, and each has checksums of its own.
absl::Status CheckVersion(const io::AppendFile& file, const std::string& head) {
  if (head.size() < kSegmentHeadSize) return absl::OkStatus();
  const std::string number = head.substr(kSegmentMagicSize);
  const uint32_t version = ByteReader(number).Read<uint32_t>();
  if (version <= kVersion || head != HeadOfVersion(version)) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat(file.path(), " was written by a newer version of isthmus (format ", version,
                   ", this one knows ", kVersion, "): use that one"));
}

// The place of the next whole header, from `offset` on.
absl::StatusOr<std::optional<uint64_t>> FindHeader(const io::AppendFile& file, uint64_t offset) {
  const std::string magic(kScanMagic, kScanMagicSize);
  while (offset + kScanHeaderSize <= file.size()) {
    absl::StatusOr<std::string> bytes = file.Read(offset, kSearchBytes);
    if (!bytes.ok()) return bytes.status();
    if (bytes->size() < kScanHeaderSize) break;
    size_t at = bytes->find(magic);
    for (; at != std::string::npos; at = bytes->find(magic, at + 1)) {
      if (at + kScanHeaderSize > bytes->size()) break;
      if (DecodeScanHeader(bytes->substr(at, kScanHeaderSize))) return offset + at;
    }
    offset += bytes->size() - kScanHeaderSize + 1;
  }
  return std::optional<uint64_t>();
}

// The record at `offset`, if there is a whole one.
absl::StatusOr<std::optional<ScanPlace>> ReadPlace(const io::AppendFile& file, uint64_t offset,
                                                   Look look) {
  absl::StatusOr<std::string> head = file.Read(offset, kScanHeaderSize);
  if (!head.ok()) return head.status();
  const std::optional<ScanHeader> header = DecodeScanHeader(*head);
  const uint64_t body_at = offset + kScanHeaderSize;
  if (!header || header->body_size > file.size() - body_at) return std::optional<ScanPlace>();
  if (look == Look::kBodies) {
    absl::StatusOr<std::string> body = file.Read(body_at, header->body_size);
    if (!body.ok()) return body.status();
    if (!IsWhole(*header, *body)) return std::optional<ScanPlace>();
  }
  return ScanPlace{offset, *header};
}

}  // namespace

std::string MakeSegmentHead() { return HeadOfVersion(kVersion); }

std::string SegmentName(int number) { return absl::StrFormat("%06d%s", number, kSuffix); }

std::vector<int> ListSegments(const std::string& folder) {
  std::vector<int> numbers;
  std::error_code error;
  for (std::filesystem::directory_iterator it(folder, error), end; !error && it != end;
       it.increment(error)) {
    const std::string name = it->path().filename().string();
    int number = 0;
    if (absl::EndsWith(name, kSuffix) && absl::SimpleAtoi(it->path().stem().string(), &number) &&
        number > 0) {
      numbers.push_back(number);
    }
  }
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

absl::StatusOr<SegmentIndex> IndexSegment(const io::AppendFile& file, Look look) {
  absl::StatusOr<std::string> head = file.Read(0, kSegmentHeadSize);
  if (!head.ok()) return head.status();
  if (absl::Status status = CheckVersion(file, *head); !status.ok()) return status;
  SegmentIndex index;
  uint64_t at = 0;
  if (*head == MakeSegmentHead()) at = index.end = kSegmentHeadSize;
  while (at < file.size()) {
    absl::StatusOr<std::optional<ScanPlace>> place = ReadPlace(file, at, look);
    if (!place.ok()) return place.status();
    if (!*place) {
      absl::StatusOr<std::optional<uint64_t>> next = FindHeader(file, at + 1);
      if (!next.ok()) return next.status();
      if (!*next) break;
      at = **next;
      continue;
    }
    // All between two records belongs to none.
    if (index.end < at) index.damaged.push_back({index.end, at - index.end});
    index.scans.push_back(**place);
    at = index.end = at + kScanHeaderSize + (*place)->header.body_size;
  }
  return index;
}

}  // namespace isthmus::storage
