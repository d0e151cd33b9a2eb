#include "core/formats/mcap_writer.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/codec/column.h"
#include "core/io/crc32.h"

namespace isthmus::formats {
namespace {

// Codes of the specification, "Records".
enum class McapOp : uint8_t {
  kHeader = 1,
  kFooter = 2,
  kSchema = 3,
  kChannel = 4,
  kMessage = 5,
  kChunk = 6,
  kMessageIndex = 7,
  kChunkIndex = 8,
  kStatistics = 11,
  kSummaryOffset = 14,
  kDataEnd = 15,
};

constexpr char kMcapMagic[] = "\x89MCAP0\r\n";

template <typename T>
void AddNumber(T value, std::string* out) {
  char bytes[sizeof(T)];
  codec::StoreAs(value, bytes);
  out->append(bytes, sizeof(T));
}

void AddText(const std::string& text, std::string* out) {
  AddNumber(static_cast<uint32_t>(text.size()), out);
  out->append(text);
}

std::string Record(McapOp op, const std::string& content) {
  std::string record(1, static_cast<char>(op));
  AddNumber(static_cast<uint64_t>(content.size()), &record);
  return record + content;
}

std::string ChannelCounts(const std::map<uint16_t, uint64_t>& counts) {
  std::string pairs;
  for (const auto& [channel, count] : counts) {
    AddNumber(channel, &pairs);
    AddNumber(count, &pairs);
  }
  return pairs;
}

}  // namespace

McapWriter::McapWriter(Sink sink, size_t chunk_bytes)
    : sink_(std::move(sink)), chunk_bytes_(chunk_bytes) {
  std::string header;
  AddText("", &header);  // No profile.
  AddText("isthmus", &header);
  Emit(kMcapMagic + Record(McapOp::kHeader, header));
}

uint16_t McapWriter::AddSchema(const std::string& name, const std::string& encoding,
                               const std::string& data) {
  const auto number = static_cast<uint16_t>(schemas_.size() + 1);
  std::string content;
  AddNumber(number, &content);
  AddText(name, &content);
  AddText(encoding, &content);
  AddText(data, &content);
  schemas_.push_back(Record(McapOp::kSchema, content));
  chunk_ += schemas_.back();
  return number;
}

uint16_t McapWriter::AddChannel(uint16_t schema, const std::string& topic,
                                const std::string& encoding) {
  const auto number = static_cast<uint16_t>(channels_.size());
  std::string content;
  AddNumber(number, &content);
  AddNumber(schema, &content);
  AddText(topic, &content);
  AddText(encoding, &content);
  AddNumber<uint32_t>(0, &content);  // No metadata.
  channels_.emplace_back().record = Record(McapOp::kChannel, content);
  chunk_ += channels_.back().record;
  return number;
}

void McapWriter::Write(uint16_t channel, int64_t time_ns, const std::string& data) {
  Channel& to = channels_.at(channel);
  const auto time = static_cast<uint64_t>(std::max<int64_t>(time_ns, 0));
  const bool is_first = std::all_of(channels_.begin(), channels_.end(),
                                    [](const Channel& any) { return any.index.empty(); });
  first_ns_ = is_first ? time : std::min(first_ns_, time);
  last_ns_ = is_first ? time : std::max(last_ns_, time);
  to.index.emplace_back(time, chunk_.size());
  std::string content;
  AddNumber(channel, &content);
  AddNumber(to.messages++, &content);
  AddNumber(time, &content);
  AddNumber(time, &content);
  chunk_ += Record(McapOp::kMessage, content + data);
  if (chunk_.size() >= chunk_bytes_) FlushChunk();
}

void McapWriter::Emit(const std::string& bytes) {
  crc_ = io::Crc32(bytes, crc_);
  written_ += bytes.size();
  is_well_ = is_well_ && sink_(bytes);
}

void McapWriter::FlushChunk() {
  if (chunk_.empty()) return;
  ChunkPlace& place = chunks_.emplace_back();
  place = {first_ns_, last_ns_, written_, 0, 0, chunk_.size(), {}};
  std::string content;
  AddNumber(first_ns_, &content);
  AddNumber(last_ns_, &content);
  AddNumber(static_cast<uint64_t>(chunk_.size()), &content);
  AddNumber(io::Crc32(chunk_), &content);
  AddText("", &content);  // Not compressed.
  AddNumber(static_cast<uint64_t>(chunk_.size()), &content);
  Emit(Record(McapOp::kChunk, content + chunk_));
  place.length = written_ - place.start;
  chunk_.clear();
  first_ns_ = last_ns_ = 0;
  const uint64_t indexes = written_;
  for (size_t i = 0; i < channels_.size(); ++i) {
    const auto index = std::exchange(channels_[i].index, {});
    if (index.empty()) continue;
    place.indexes[static_cast<uint16_t>(i)] = written_;
    std::string entries, record;
    for (const auto& [time, offset] : index) {
      AddNumber(time, &entries);
      AddNumber(offset, &entries);
    }
    AddNumber(static_cast<uint16_t>(i), &record);
    AddText(entries, &record);
    Emit(Record(McapOp::kMessageIndex, record));
  }
  place.index_length = written_ - indexes;
}

std::string McapWriter::Statistics() const {
  uint64_t messages = 0, first = std::numeric_limits<uint64_t>::max(), last = 0;
  std::map<uint16_t, uint64_t> counts;
  for (size_t i = 0; i < channels_.size(); ++i) {
    messages += channels_[i].messages;
    counts[static_cast<uint16_t>(i)] = channels_[i].messages;
  }
  for (const ChunkPlace& place : chunks_) {
    if (place.indexes.empty()) continue;  // The chunk has only schemas and channels.
    first = std::min(first, place.first_ns);
    last = std::max(last, place.last_ns);
  }
  std::string content;
  AddNumber(messages, &content);
  AddNumber(static_cast<uint16_t>(schemas_.size()), &content);
  AddNumber(static_cast<uint32_t>(channels_.size()), &content);
  AddNumber<uint32_t>(0, &content);  // Attachments,
  AddNumber<uint32_t>(0, &content);  // metadata.
  AddNumber(static_cast<uint32_t>(chunks_.size()), &content);
  AddNumber(messages == 0 ? 0 : first, &content);
  AddNumber(last, &content);
  AddText(ChannelCounts(counts), &content);
  return Record(McapOp::kStatistics, content);
}

void McapWriter::WriteSummary() {
  std::string schemas, channels, chunks;
  for (const std::string& schema : schemas_) schemas += schema;
  for (const Channel& channel : channels_) channels += channel.record;
  for (const ChunkPlace& place : chunks_) {
    std::string content;
    for (const uint64_t number : {place.first_ns, place.last_ns, place.start, place.length}) {
      AddNumber(number, &content);
    }
    AddText(ChannelCounts(place.indexes), &content);
    AddNumber(place.index_length, &content);
    AddText("", &content);
    AddNumber(place.size, &content);
    AddNumber(place.size, &content);
    chunks += Record(McapOp::kChunkIndex, content);
  }
  const std::pair<McapOp, std::string> groups[] = {{McapOp::kSchema, schemas},
                                                   {McapOp::kChannel, channels},
                                                   {McapOp::kStatistics, Statistics()},
                                                   {McapOp::kChunkIndex, chunks}};
  const uint64_t start = written_;
  crc_ = 0;  // From here on, the summary's.
  std::string offsets;
  for (const auto& [op, records] : groups) {
    if (records.empty()) continue;
    std::string content(1, static_cast<char>(op));
    AddNumber(written_, &content);
    AddNumber(static_cast<uint64_t>(records.size()), &content);
    offsets += Record(McapOp::kSummaryOffset, content);
    Emit(records);
  }
  const uint64_t offset_start = written_;
  Emit(offsets);
  std::string footer;
  AddNumber(start, &footer);
  AddNumber(offset_start, &footer);
  // The checksum is of all before itself, so also of how the footer begins.
  const std::string begun = Record(McapOp::kFooter, footer + std::string(4, '\0'));
  Emit(begun.substr(0, begun.size() - 4));
  std::string crc;
  AddNumber(crc_, &crc);
  Emit(crc + kMcapMagic);
}

bool McapWriter::Finish() {
  FlushChunk();
  std::string crc;
  AddNumber(crc_, &crc);
  Emit(Record(McapOp::kDataEnd, crc));
  WriteSummary();
  return is_well_;
}

}  // namespace isthmus::formats
