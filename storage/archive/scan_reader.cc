#include "storage/archive/scan_reader.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <utility>

#include "storage/archive/scan_record.h"
#include "storage/archive/scan_segment.h"

namespace isthmus::storage {
namespace {

constexpr size_t kDamageListed = 100;

}  // namespace

absl::StatusOr<std::unique_ptr<ScanReader>> ScanReader::Open(const std::string& directory,
                                                             const SessionId& session) {
  const std::string folder = absl::StrCat(directory, "/scans/", session.value());
  const std::vector<int> numbers = ListSegments(folder);
  if (numbers.empty()) {
    return absl::NotFoundError(
        absl::StrCat("there are no scans of session ", session.value(), " in ", directory));
  }
  std::unique_ptr<ScanReader> reader(new ScanReader);
  for (const int number : numbers) {
    const std::string path = absl::StrCat(folder, "/", SegmentName(number));
    const absl::Status status = reader->AddSegment(path, number == numbers.back());
    if (!status.ok()) return status;
  }
  std::stable_sort(
      reader->places_.begin(), reader->places_.end(),
      [](const auto& a, const auto& b) { return a.record.sequence < b.record.sequence; });
  for (size_t i = 0; i < reader->places_.size(); ++i) {
    const bool is_copy =
        i > 0 && reader->places_[i].record.sequence == reader->places_[i - 1].record.sequence;
    if (!is_copy) ++reader->scans_;
  }
  return reader;
}

absl::Status ScanReader::AddSegment(const std::string& path, bool is_last) {
  auto file = io::AppendFile::OpenToRead(path);
  if (!file.ok()) return file.status();
  const absl::StatusOr<io::RecordIndex> index = IndexSegment(**file, io::Look::kHeaders);
  if (!index.ok()) return index.status();
  for (const io::Record& record : index->records) places_.push_back({segments_.size(), record});
  for (const io::DamagedBytes& damaged : index->damaged) {
    AddDamage(
        absl::StrCat(path, ": ", damaged.size, " bytes at ", damaged.offset, " belong to no scan"));
  }
  if (const uint64_t rest = (*file)->size() - index->end; rest > 0 && is_last) {
    unfinished_bytes_ = rest;
  } else if (rest > 0) {
    AddDamage(absl::StrCat(path, ": its last ", rest, " bytes belong to no scan"));
  }
  segments_.push_back(*std::move(file));
  return absl::OkStatus();
}

void ScanReader::AddDamage(std::string what) {
  ++damaged_count_;
  if (damage_.size() < kDamageListed) damage_.push_back(std::move(what));
}

absl::StatusOr<std::optional<ScanUpload>> ScanReader::Read(const Place& place,
                                                           std::string& problem) const {
  const io::AppendFile& file = *segments_[place.segment];
  absl::StatusOr<ScanUpload> scan;
  if (const auto body = io::ReadBody(file, place.record); body.ok()) {
    scan = DecodeScan(place.record, *body);
  } else {
    scan = body.status();
  }
  if (scan.ok()) return *std::move(scan);
  if (!absl::IsDataLoss(scan.status())) return scan.status();
  problem = absl::StrCat(file.path(), ": scan ", place.record.sequence, " at ",
                         place.record.begin(), ": ", scan.status().message());
  return std::optional<ScanUpload>();
}

absl::StatusOr<std::optional<ScanUpload>> ScanReader::Next() {
  while (next_ < places_.size()) {
    const uint64_t sequence = places_[next_].record.sequence;
    std::optional<ScanUpload> scan;
    std::string problem;
    for (; next_ < places_.size() && places_[next_].record.sequence == sequence; ++next_) {
      if (scan) continue;
      auto read = Read(places_[next_], problem);
      if (!read.ok()) return read.status();
      scan = *std::move(read);
    }
    if (!problem.empty()) AddDamage(std::move(problem));
    if (scan) return scan;
  }
  return std::optional<ScanUpload>();
}

}  // namespace isthmus::storage
