#include "storage/archive/scan_segment.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include "core/byte_stream.h"
#include "core/io/crc32c.h"
#include "core/io/folder.h"

namespace isthmus::storage {
namespace {

constexpr char kSegmentMagic[] = "ISTHSCAN";
constexpr size_t kSegmentMagicSize = 8;
constexpr uint32_t kVersion = 1;
constexpr char kSuffix[] = ".scans";

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

}  // namespace

std::string MakeSegmentHead() { return HeadOfVersion(kVersion); }

std::string SegmentName(int number) { return absl::StrFormat("%06d%s", number, kSuffix); }

std::vector<int> ListSegments(const std::string& folder) {
  const auto numbers = io::ListNumbers(folder, kSuffix);
  if (!numbers.ok()) return {};
  return {numbers->begin(), numbers->end()};
}

absl::StatusOr<io::RecordIndex> IndexSegment(const io::AppendFile& file, io::Look look) {
  absl::StatusOr<std::string> head = file.Read(0, kSegmentHeadSize);
  if (!head.ok()) return head.status();
  if (absl::Status status = CheckVersion(file, *head); !status.ok()) return status;
  return io::FindRecords(file, kScanMarker, *head == MakeSegmentHead() ? kSegmentHeadSize : 0,
                         look);
}

}  // namespace isthmus::storage
