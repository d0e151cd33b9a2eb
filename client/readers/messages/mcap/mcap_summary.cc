#include <absl/strings/str_cat.h>

#include <algorithm>
#include <utility>

#include "client/readers/messages/field_reader.h"
#include "client/readers/messages/limits.h"
#include "client/readers/messages/mcap/mcap_chunks.h"
#include "client/readers/messages/mcap/mcap_records.h"
#include "core/codec/column.h"
#include "core/io/crc32.h"

namespace isthmus::readers {
namespace {

// The counts of a summary beside its chunks.
struct SummaryCounts {
  bool told = false;  // True if there is a statistics record.
  uint64_t messages = 0;
  uint32_t chunks = 0;
  std::map<uint32_t, uint64_t> totals;
};

bool TakeStatistics(absl::string_view content, SummaryCounts* counts) {
  FieldReader reader = FieldReader::Plain(content);
  counts->messages = reader.Read<uint64_t>();
  reader.Skip(2 + 4 + 4 + 4);  // Schemas, channels, attachments, metadata.
  counts->chunks = reader.Read<uint32_t>();
  reader.Skip(16);  // First and last time.
  const auto size = reader.Read<uint32_t>();
  for (uint32_t i = 0; i < size / 10 && reader.ok(); ++i) {
    const auto channel = reader.Read<uint16_t>();
    counts->totals[channel] = reader.Read<uint64_t>();
  }
  counts->told = reader.ok();
  return reader.ok();
}

bool TakeChunkIndex(absl::string_view content, std::vector<MessageBlock>* blocks) {
  FieldReader reader = FieldReader::Plain(content);
  MessageBlock block;
  block.first_ns = static_cast<int64_t>(reader.Read<uint64_t>());
  block.last_ns = static_cast<int64_t>(reader.Read<uint64_t>());
  block.begin = reader.Read<uint64_t>();
  const auto length = reader.Read<uint64_t>();
  block.end = block.begin + length;
  block.counted = false;
  const auto size = reader.Read<uint32_t>();
  for (uint32_t i = 0; i < size / 10 && reader.ok(); ++i) {
    if (!block.counts) block.counts.emplace();
    (*block.counts)[reader.Read<uint16_t>()] = 1;
    reader.Skip(8);  // Offset of its message index.
  }
  blocks->push_back(std::move(block));
  return reader.ok() && length <= 2 * kMaxChunkBytes;
}

absl::Status TakeRecords(absl::string_view summary, BlockFile* file, SummaryCounts* counts) {
  for (size_t at = 0; at < summary.size();) {
    absl::StatusOr<BlockRecord> record = ParseMcapRecord(summary, at);
    if (!record.ok()) return record.status();
    const absl::string_view content =
        summary.substr(at + kMcapHeadBytes, record->end - at - kMcapHeadBytes);
    const auto op = static_cast<McapOp>(summary[at]);
    bool fits = true;
    if (op == McapOp::kStatistics) fits = TakeStatistics(content, counts);
    if (op == McapOp::kChunkIndex) fits = TakeChunkIndex(content, &file->blocks);
    if (!fits) return absl::DataLossError("a record of the summary is damaged");
    if (record->declared) file->numbered[record->number] = *std::move(record->declared);
    if (op == McapOp::kSchema) file->schemas[record->number] = std::move(record->schema);
    at = record->end;
  }
  return absl::OkStatus();
}

// The summary's records, whose CRC was checked; NotFound where there are none.
absl::StatusOr<std::string> LoadSummary(const ByteSource& source) {
  const size_t tail = kMcapHeadBytes + kMcapFooterBytes + kMcapMagic.size();
  const uint64_t size = source.size();
  const absl::Status cut = absl::DataLossError(absl::StrCat(
      "the file is cut off at byte ", size, ": nothing tells how many messages are missing"));
  if (size < 2 * kMcapMagic.size() + tail) return cut;
  ByteWindow window(source, tail);
  absl::StatusOr<absl::string_view> bytes = window.At(size - tail, tail);
  if (!bytes.ok()) return bytes.status();
  if (bytes->substr(tail - kMcapMagic.size()) != kMcapMagic ||
      static_cast<McapOp>((*bytes)[0]) != McapOp::kFooter) {
    return cut;
  }
  const auto begin = codec::LoadAs<uint64_t>(bytes->data() + kMcapHeadBytes);
  const auto crc = codec::LoadAs<uint32_t>(bytes->data() + kMcapHeadBytes + 16);
  const uint64_t end = size - tail;
  if (begin == 0) return absl::NotFoundError("the file has no summary");
  if (begin > end || end - begin > kMaxChunkBytes) {
    return absl::DataLossError("the summary's offset cannot be right");
  }
  // The CRC goes up to itself.
  std::string summary(size - tail - begin + kMcapHeadBytes + 16, '\0');
  if (auto read = source.Read(begin, summary.size(), summary.data()); !read.ok()) return read;
  if (crc != 0 && crc != io::Crc32(summary)) {
    return absl::DataLossError("the CRC of the summary is wrong");
  }
  summary.resize(end - begin);
  return summary;
}

}  // namespace

absl::Status ReadMcapSummary(const ByteSource& source, BlockFile* file,
                             std::map<uint32_t, uint64_t>* totals) {
  absl::StatusOr<std::string> summary = LoadSummary(source);
  if (!summary.ok()) return summary.status();
  SummaryCounts counts;
  if (auto status = TakeRecords(*summary, file, &counts); !status.ok()) return status;
  if (!counts.told && file->blocks.empty()) {
    return absl::NotFoundError("the summary indexes no chunks");
  }
  if (counts.told &&
      (counts.chunks != file->blocks.size() || (file->blocks.empty() && counts.messages > 0))) {
    return absl::NotFoundError("the summary does not index all chunks");
  }
  for (const MessageBlock& block : file->blocks) {
    if (!block.counts) continue;
    for (const auto& count : *block.counts) {
      if (!file->numbered.contains(count.first)) {
        return absl::NotFoundError("the summary does not name all channels");
      }
    }
  }
  // Without statistics a file without channels in its summary tells nothing.
  if (file->numbered.empty() && !file->blocks.empty()) {
    return absl::NotFoundError("the summary names no channels");
  }
  std::sort(file->blocks.begin(), file->blocks.end(),
            [](const MessageBlock& a, const MessageBlock& b) { return a.begin < b.begin; });
  *totals = std::move(counts.totals);
  return absl::OkStatus();
}

}  // namespace isthmus::readers
