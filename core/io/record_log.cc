#include "core/io/record_log.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "core/byte_stream.h"
#include "core/io/crc32c.h"

namespace isthmus::io {
namespace {

constexpr uint64_t kMarkerBytes = 4, kCheckedBytes = kRecordHeaderBytes - sizeof(uint32_t);
constexpr uint64_t kSearchBytes = 1 << 16;  // Read at a time while a record is looked for.

class Finder {
 public:
  Finder(const AppendFile& file, const char marker[4], Look look)
      : file_(file), marker_(marker, kMarkerBytes), look_(look) {}

  absl::StatusOr<RecordIndex> Find(uint64_t begin) {
    RecordIndex index;
    index.end = begin;
    for (std::optional<Record> record; (record = Next(index.end)); index.end = record->end()) {
      if (index.end < record->begin()) {
        index.damaged.push_back({index.end, record->begin() - index.end});
      }
      index.records.push_back(*record);
      unread_ = absl::OkStatus();
    }
    if (!unread_.ok()) return unread_;
    return index;
  }

 private:
  // The first at `from` or behind it.
  std::optional<Record> Next(uint64_t from) {
    if (const auto record = At(from, Read(from, kRecordHeaderBytes))) return record;
    for (uint64_t start = from + 1; start + kRecordHeaderBytes <= file_.size();) {
      const std::string piece = Read(start, kSearchBytes);
      for (size_t at = piece.find(marker_); at != std::string::npos;
           at = piece.find(marker_, at + 1)) {
        const auto record = At(start + at, piece.substr(at, kRecordHeaderBytes));
        if (record) return record;
      }
      // Pieces overlap, so that a header across their border is seen.
      start += kSearchBytes - kRecordHeaderBytes + 1;
    }
    return std::nullopt;
  }

  std::optional<Record> At(uint64_t begin, const std::string& header) {
    if (header.size() < kRecordHeaderBytes || header.compare(0, kMarkerBytes, marker_) != 0) {
      return std::nullopt;
    }
    ByteReader reader(header);
    reader.ReadString(kMarkerBytes);
    Record record;
    record.size = reader.Read<uint32_t>();
    record.sequence = reader.Read<uint64_t>();
    record.stamp_ns = reader.Read<int64_t>();
    record.crc32c = reader.Read<uint32_t>();
    record.offset = begin + kRecordHeaderBytes;
    if (reader.Read<uint32_t>() != Crc32c(header.data(), kCheckedBytes) ||
        record.end() > file_.size()) {
      return std::nullopt;
    }
    if (look_ == Look::kHeaders) return record;
    const absl::StatusOr<std::string> body = ReadBody(file_, record);
    if (body.ok()) return record;
    if (!absl::IsDataLoss(body.status())) unread_ = body.status();
    return std::nullopt;
  }

  std::string Read(uint64_t offset, uint64_t size) {
    absl::StatusOr<std::string> bytes = file_.Read(offset, size);
    if (bytes.ok()) return *std::move(bytes);
    unread_ = bytes.status();
    return {};
  }

  const AppendFile& file_;
  const std::string marker_;
  const Look look_;
  absl::Status unread_;  // Why bytes behind the last record found could not be read.
};

}  // namespace

absl::StatusOr<Record> AppendRecord(AppendFile& file, const char marker[4], uint64_t sequence,
                                    int64_t stamp_ns, const std::string& body) {
  const Record record{sequence, stamp_ns, file.size() + kRecordHeaderBytes,
                      static_cast<uint32_t>(body.size()), Crc32c(body.data(), body.size())};
  std::string bytes(marker, kMarkerBytes);
  bytes.reserve(kRecordHeaderBytes + body.size());
  AppendBytes(record.size, bytes);
  AppendBytes(record.sequence, bytes);
  AppendBytes(record.stamp_ns, bytes);
  AppendBytes(record.crc32c, bytes);
  AppendBytes(Crc32c(bytes.data(), bytes.size()), bytes);
  bytes += body;
  if (absl::Status status = file.Append(bytes); !status.ok()) return status;
  return record;
}

absl::StatusOr<RecordIndex> FindRecords(const AppendFile& file, const char marker[4],
                                        uint64_t begin, Look look) {
  return Finder(file, marker, look).Find(begin);
}

absl::StatusOr<std::string> ReadBody(const AppendFile& file, const Record& record) {
  absl::StatusOr<std::string> body = file.Read(record.offset, record.size);
  if (!body.ok()) return body;
  if (body->size() == record.size && Crc32c(body->data(), body->size()) == record.crc32c) {
    return body;
  }
  return absl::DataLossError(absl::StrCat("the checksum of record ", record.sequence, " in ",
                                          file.path(), " is wrong: it is damaged"));
}

}  // namespace isthmus::io
