#include "client/readers/messages/bag/bag_records.h"

#include <absl/strings/str_cat.h>

#include <string>

#include "client/readers/messages/limits.h"
#include "core/codec/column.h"

namespace isthmus::readers {
namespace {

struct BagField {
  absl::string_view name, value;
};

// Takes the first field off `header`; empty where it does not fit.
std::optional<BagField> TakeField(absl::string_view& header) {
  if (header.size() < 4) return std::nullopt;
  const auto size = codec::LoadAs<uint32_t>(header.data());
  if (size > header.size() - 4) return std::nullopt;
  const absl::string_view field = header.substr(4, size);
  header.remove_prefix(4 + size);
  const size_t equals = field.find('=');
  if (equals == absl::string_view::npos) return std::nullopt;
  return BagField{field.substr(0, equals), field.substr(equals + 1)};
}

// False for a value of another size than T.
template <typename T>
bool TakeNumber(absl::string_view value, T& number) {
  if (value.size() != sizeof(T)) return false;
  number = codec::LoadAs<T>(value.data());
  return true;
}

bool TakeValue(const BagField& field, BagHeader& header) {
  const auto& [name, value] = field;
  if (name == "conn") return TakeNumber(value, header.conn);
  if (name == "time") return TakeNumber(value, header.time);
  if (name == "start_time") return TakeNumber(value, header.start_time);
  if (name == "end_time") return TakeNumber(value, header.end_time);
  if (name == "size") return TakeNumber(value, header.size);
  if (name == "count") return TakeNumber(value, header.count);
  if (name == "conn_count") return TakeNumber(value, header.conn_count);
  if (name == "chunk_count") return TakeNumber(value, header.chunk_count);
  if (name == "index_pos") return TakeNumber(value, header.index_pos);
  if (name == "chunk_pos") return TakeNumber(value, header.chunk_pos);
  if (name == "compression") header.compression = value;
  if (name == "topic") header.topic = value;
  if (name == "encryptor") header.encryptor = value;
  return true;
}

absl::Status NoRecord(uint64_t offset) {
  return absl::DataLossError(absl::StrCat("no record begins at byte ", offset));
}

}  // namespace

std::optional<BagHeader> ParseBagHeader(absl::string_view header) {
  BagHeader parsed;
  uint8_t op = 0;
  while (!header.empty()) {
    const std::optional<BagField> field = TakeField(header);
    if (!field) return std::nullopt;
    const bool fits =
        field->name == "op" ? TakeNumber(field->value, op) : TakeValue(*field, parsed);
    if (!fits) return std::nullopt;
  }
  if (op < static_cast<uint8_t>(BagOp::kMessage) || op > static_cast<uint8_t>(BagOp::kConnection)) {
    return std::nullopt;
  }
  parsed.op = static_cast<BagOp>(op);
  return parsed;
}

absl::StatusOr<BagHead> ReadBagHead(ByteWindow& window, uint64_t offset) {
  absl::StatusOr<absl::string_view> length = window.At(offset, 4);
  if (!length.ok()) return length.status();
  const auto header_size = codec::LoadAs<uint32_t>(length->data());
  if (header_size > kMaxBagHeaderBytes) return NoRecord(offset);
  absl::StatusOr<absl::string_view> bytes = window.At(offset, size_t{header_size} + 8);
  if (!bytes.ok()) return bytes.status();
  const std::optional<BagHeader> header = ParseBagHeader(bytes->substr(4, header_size));
  if (!header) return NoRecord(offset);
  const uint64_t begin = offset + header_size + 8;
  return BagHead{*header, begin, begin + codec::LoadAs<uint32_t>(bytes->data() + 4 + header_size)};
}

absl::StatusOr<BlockRecord> ParseBagRecord(absl::string_view content, size_t at) {
  absl::string_view rest = content.substr(at);
  if (rest.size() < 8) return NoRecord(at);
  const auto header_size = codec::LoadAs<uint32_t>(rest.data());
  if (header_size > rest.size() - 8) return NoRecord(at);
  const std::optional<BagHeader> header = ParseBagHeader(rest.substr(4, header_size));
  const auto data_size = codec::LoadAs<uint32_t>(rest.data() + 4 + header_size);
  rest.remove_prefix(size_t{header_size} + 8);
  if (!header || data_size > rest.size()) return NoRecord(at);
  BlockRecord record;
  record.end = content.size() - rest.size() + data_size;
  record.number = header->conn;
  record.bytes = rest.substr(0, data_size);
  record.is_message = header->op == BagOp::kMessage;
  record.log_ns = header->time_ns();
  if (header->op == BagOp::kConnection) {
    record.declared = ParseConnection(header->topic, record.bytes);
  }
  return record;
}

NumberedTopic ParseConnection(absl::string_view topic, absl::string_view data) {
  NumberedTopic declared{std::string(topic), "", "ros1"};
  while (const std::optional<BagField> field = TakeField(data)) {
    if (field->name == "type") declared.type = std::string(field->value);
  }
  return declared;
}

}  // namespace isthmus::readers
